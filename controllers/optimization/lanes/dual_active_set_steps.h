#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/controllers/optimization/infinity.h>

// The two kinds of steps of DualActiveSet; included only by dual_active_set.cc.
namespace tenon {
namespace {

using internal::AddColumn;
using internal::AddColumns;
using internal::AddProducts;
using internal::CopyPacket;
using internal::Dot;
using internal::Dots;
using internal::KnownSize;
using internal::Lanes;
using internal::Largest;
using internal::Mask;
using internal::PacketAt;
using internal::Padded;
using internal::PaddedDown;
using internal::Products;
using internal::Reflect;

// Relative length of the part of a column of V that is normal to the other columns, below which the column
// counts as dependent. A violated constraint with a dependent column contradicts the others; a guessed one is
// dropped and may be added later.
constexpr double kDependent = 1e-12, kDependentGuess = 1e-6;
constexpr double kNegligible = 1e-13;
// Maximum number of violated constraints that are added at once; if more were added, too many would be
// dropped again.
constexpr int kFew = 3;

struct RowView {
  const double* data;
  double bound;
};
TENON_INLINE RowView ViewRow(const QuadraticProgram& qp, int constraint, int equalities) {
  if (constraint < equalities)
    return {qp.A_eq.data() + constraint * qp.A_eq.outerStride(), qp.b_eq.data()[constraint]};
  const int i = constraint - equalities;
  return {qp.A_in.data() + i * qp.A_in.outerStride(), qp.b_in.data()[i]};
}
template <class Size>
TENON_INLINE double RowProduct(const double* row, const double* x, Size n) {
  double product;
  Products(row, 0, 1, x, n, &product);
  return product;
}
// Returns the padded row, copied to `copy` if necessary.
template <class Size>
TENON_INLINE const double* PaddedRow(const double* row, double* copy, Size n) {
  if (n % 4 == 0) return row;
  for (int i = 0; i < n; i += 4) CopyPacket(row, i, n, copy);
  return copy;
}
TENON_INLINE void Copy(const double* from, double* to, int begin, int end) {
  for (int i = begin; i < end; i += 4) *PacketAt(to + i) = *PacketAt(from + i);
}

TENON_INLINE bool AreZero(const double* a) {
  return a[0] == 0 && a[1] == 0 && a[2] == 0 && a[3] == 0;
}

}  // namespace

// Several at once

// Adds column `column` of V, which is zero from `end` on, as pivot k. Returns false if it depends on the
// columns before it.
template <class Size>
TENON_INLINE bool DualActiveSet::MakePivot(const double* column, int end, double independence, int k, Size n,
                                           internal::Pivot* pivot) {
  if (k >= end) return false;
  const int N = Padded(n), from = PaddedDown(k), lane = k - from;
  double* const w = reflectors_.data() + k * N;
  const Mask here = Mask{0, 1, 2, 3} - lane;
  const Lanes around = *PacketAt(column + from), head = here < 0 ? Lanes{} : around;
  const double before = Dot(column, column, 0, from) + internal::Sum(around * around),
               rest = Dot(column, column, from + 4, end);
  const double tail = internal::Sum(head * head) + rest;
  if (!(tail > independence * independence * (before + rest))) return false;
  const double norm = std::sqrt(tail), first = column[k], alpha = first > 0 ? -norm : norm;
  const double turned = first - alpha;
  *PacketAt(w + from) = here == 0 ? Lanes{turned, turned, turned, turned} : head;
  Copy(column, w, from + 4, N);
  *pivot = {w, head, alpha, 1 / (norm * std::abs(turned)), k, end};
  inverse_alpha_[k] = 1 / alpha;
  tau_[k] = pivot->tau;
  ends_[k] = end;
  return true;
}

template <class Size>
TENON_INLINE void DualActiveSet::FactorEqualities(const QuadraticProgram& qp, Size n) {
  const int N = Padded(n), count = num_equalities_;
  double* const V = work_.data();
  for (int e = 0; e < count; ++e) {
    const RowView row = ViewRow(qp, e, count);
    const double* const padded = PaddedRow(row.data, row_.data(), n);
    int end = N;
    while (end > 4 && AreZero(padded + end - 4)) end -= 4;
    column_ends_[e] = cost_.MultiplyTransposed(padded, V + e * N, end, n);
    work_bounds_[e] = row.bound;
  }
  double* const slope = V + count * N;
  cost_.MultiplyTransposed(g_.data(), slope, n);
  for (int i = 0; i < N; i += 4) *PacketAt(y_equalities_.data() + i) = Lanes{};
  int k = 0;
  for (int e = 0; e < count; ++e) {
    const double* const column = V + e * N;
    internal::Pivot pivot;
    if (!MakePivot(column, column_ends_[e], kDependent, k, n, &pivot)) continue;
    Copy(column, R_equalities_.data() + k * N, 0, Padded(k));
    const double y = work_bounds_[e] * inverse_alpha_[k];
    y_equalities_[k] = y;
    pivot.Reflect(V + (e + 1) * N, N, count - e);
    for (int c = e + 1; c < count; ++c) {
      work_bounds_[c] -= V[c * N + k] * y;
      column_ends_[c] = std::max(column_ends_[c], pivot.end);
    }
    independent_[k++] = e;
    is_active_[e] = 1;
  }
  num_independent_ = k;
  Copy(slope, slope_equalities_.data(), 0, N);
  Copy(y_equalities_.data(), y_.data(), 0, N);
}

// Computes the columns of the inequalities `first` to `count` of active_.
template <class Size>
TENON_INLINE void DualActiveSet::MakeColumns(const QuadraticProgram& qp, int first, int count, Size n) {
  const int N = Padded(n);
  double* const V = columns_.data();
  for (int s = first; s < count; ++s) {
    const RowView row = ViewRow(qp, active_[s], num_equalities_);
    cost_.MultiplyTransposed(PaddedRow(row.data, row_.data(), n), V + s * N, n);
    bounds_[s] = row.bound;
  }
  for (int k = 0; k < num_independent_; ++k)
    Reflect(reflectors_.data() + k * N, tau_[k], V + first * N, N, count - first, PaddedDown(k), ends_[k]);
  for (int s = first; s < count; ++s) {
    norms2_[s] = Dot(V + s * N, V + s * N, 0, N);
    if (num_independent_ > 0) bounds_[s] -= Dot(V + s * N, y_equalities_.data(), 0, Padded(num_independent_));
  }
}

TENON_INLINE void DualActiveSet::MoveColumn(int from, int to, int N) {
  if (from == to) return;
  Copy(columns_.data() + from * N, columns_.data() + to * N, 0, N);
  active_[to] = active_[from];
  norms2_[to] = norms2_[from];
  bounds_[to] = bounds_[from];
}

// Factors the columns `first` to `count` after the existing ones, and drops dependent columns.
template <class Size>
TENON_INLINE void DualActiveSet::FactorColumns(int first, int count, Size n) {
  const int N = Padded(n), e = num_independent_, width = count - first;
  double* const V = work_.data();
  for (int s = 0; s < width; ++s) Copy(columns_.data() + (first + s) * N, V + s * N, 0, N);
  double* const slope = V + width * N;
  Copy(slope_equalities_.data(), slope, 0, N);
  for (int k = e; k < e + first; ++k)
    Reflect(reflectors_.data() + k * N, tau_[k], V, N, width + 1, PaddedDown(k), ends_[k]);
  for (int s = 0; s < width; ++s) {
    double bound = bounds_[first + s];
    for (int k = e; k < e + first; ++k) bound -= V[s * N + k] * y_[k];
    work_bounds_[s] = bound;
  }
  int q = first;
  for (int s = 0; s < width; ++s) {
    const double* const column = V + s * N;
    const int k = e + q, from = first + s;
    internal::Pivot pivot;
    if (!MakePivot(column, N, kDependentGuess, k, n, &pivot)) {
      is_active_[active_[from]] = 0;
      continue;
    }
    for (int i = 0; i < q; ++i) R_[q * N + i] = column[e + i];
    R_[q * N + q] = pivot.alpha;
    inverse_[q] = inverse_alpha_[k];
    const double y = work_bounds_[s] * inverse_[q];
    y_[k] = y;
    pivot.Reflect(V + (s + 1) * N, N, width - s);
    for (int c = s + 1; c < width; ++c) work_bounds_[c] -= V[c * N + k] * y;
    MoveColumn(from, q, N);
    ++q;
  }
  num_active_ = q;
  Copy(slope, slope_.data(), 0, N);
}

// Solves R u = t for the inequalities' part of R, in place.
template <class Size>
TENON_INLINE void DualActiveSet::SolveR(double* t, double* u, Size n) const {
  const int N = Padded(n);
  for (int k = num_active_ - 1; k >= 0; --k) {
    u[k] = t[k] * inverse_[k];
    AddColumn(R_.data() + k * N, -u[k], t, 0, Padded(k));
  }
}

// Adds the inequalities `first` to `count` of active_ to the active set, drops those whose multipliers would
// be negative, and computes the minimum. Returns the number of dropped inequalities.
template <class Size>
TENON_VECTOR_CLONES int DualActiveSet::Join(const QuadraticProgram& qp, int first, int count, Size n) {
  const int N = Padded(n), e = num_independent_;
  MakeColumns(qp, first, count, n);
  int dropped = 0;
  while (true) {
    FactorColumns(first, count, n);
    gain_ = 0;
    for (int k = 0; k < num_active_; ++k) {
      r_[k] = y_[e + k] + slope_[e + k];
      gain_ += r_[k] * r_[k];
    }
    SolveR(r_.data(), u_.data(), n);
    first = 0;
    while (first < num_active_ && u_[first] >= 0) ++first;
    if (first == num_active_) break;
    count = first;
    for (int k = first; k < num_active_; ++k) {
      if (u_[k] >= 0) {
        MoveColumn(k, count++, N);
      } else {
        is_active_[active_[k]] = 0;
        ++dropped;
      }
    }
  }
  for (int i = 0; i < N; i += 4) {
    const Mask index = Mask{0, 1, 2, 3} + i;
    *PacketAt(w_.data() + i) =
        index < e + num_active_ ? *PacketAt(y_.data() + i) : -*PacketAt(slope_.data() + i);
  }
  for (int k = e + num_active_ - 1; k >= 0; --k)
    Reflect(reflectors_.data() + k * N, tau_[k], w_.data(), N, 1, PaddedDown(k), ends_[k]);
  cost_.MultiplyFactor(w_.data(), x_.data(), n);
  return dropped;
}

// Factors the equalities and the usable part of the guess, and computes x and its multipliers.
template <class Size>
TENON_INLINE void DualActiveSet::Start(const QuadraticProgram& qp, Size n) {
  std::fill(is_active_.begin(), is_active_.end(), 0);
  z_is_formed_ = false;
  FactorEqualities(qp, n);
  int count = 0;
  for (int k = 0; k < num_guess_; ++k) {
    const int constraint = guess_[k];
    if (is_active_[constraint] != 0) continue;
    is_active_[constraint] = 1;
    active_[count++] = constraint;
  }
  Join(qp, 0, count, n);
}

// One at a time

template <class Size>
TENON_INLINE void DualActiveSet::FormZ(const QuadraticProgram& qp, Size n) {
  if (z_is_formed_) return;
  z_is_formed_ = true;
  internal::Transpose(qp.A_in.data(), qp.A_in.outerStride(), num_inequalities_, n, transposed_.data(),
                      Padded(num_inequalities_));
  const int N = Padded(n), e = num_independent_, p = n - e;
  double* const Z = Z_.data();
  if (e + num_active_ == 0) {
    cost_.CopyFactor(Z, n);
    return;
  }
  for (int c = 0; c < p; ++c) {
    for (int i = 0; i < N; i += 4) *PacketAt(Z + c * N + i) = Lanes{};
    Z[c * N + e + c] = 1;
  }
  for (int k = e + num_active_ - 1; k >= 0; --k) {
    const int c = std::max(0, k - e);
    Reflect(reflectors_.data() + k * N, tau_[k], Z + c * N, N, p - c, PaddedDown(k), ends_[k]);
  }
  for (int c = 0; c < p; ++c) {
    Copy(Z + c * N, w_.data(), 0, N);
    cost_.MultiplyFactor(w_.data(), Z + c * N, n);
  }
}

// products = Z^T a
template <class Size>
TENON_INLINE void DualActiveSet::MultiplyZTransposed(const double* a, double* products, Size n) const {
  const int N = Padded(n);
  for (int c = 0; c < n - num_independent_; c += 4) Dots(Z_.data() + c * N, N, a, 0, N, products + c);
}

// sum += Z s, for the columns from `first` to `last`.
template <class Size>
TENON_INLINE void DualActiveSet::AddZ(const double* s, int first, int last, double* sum, Size n) const {
  const int N = Padded(n);
  for (; first + 4 <= last; first += 4) AddColumns(Z_.data() + first * N, N, s + first, sum, 0, N);
  for (; first < last; ++first) AddColumn(Z_.data() + first * N, s[first], sum, 0, N);
}

// Step 2 of the paper: raises the multiplier of a violated constraint until it is satisfied, and drops
// constraints whose multipliers would become negative.
template <class Size>
TENON_VECTOR_CLONES DualActiveSet::Outcome DualActiveSet::AddViolated(const QuadraticProgram& qp,
                                                                      int constraint, int* iterations,
                                                                      Size n) {
  FormZ(qp, n);
  const int N = Padded(n), p = n - num_independent_;
  const RowView view = ViewRow(qp, constraint, num_equalities_);
  const double* const row = PaddedRow(view.data, row_.data(), n);
  double slack = Dot(row, x_.data(), 0, N) - view.bound;
  MultiplyZTransposed(row, d_.data(), n);
  // |J^T a|^2; without equalities it is |Z^T a|^2.
  double norm2 = 0;
  if (num_independent_ == 0) {
    for (int c = 0; c < p; ++c) norm2 += d_[c] * d_[c];
  } else {
    cost_.MultiplyTransposed(row, w_.data(), n);
    norm2 = Dot(w_.data(), w_.data(), 0, N);
  }
  double multiplier = 0, normal = 0;
  while (true) {
    if (*iterations >= max_iterations_) return {QpStatus::kIterationLimit, constraint};
    ++*iterations;
    const int q = num_active_;
    Copy(d_.data(), w_.data(), 0, N);
    SolveR(w_.data(), r_.data(), n);
    double dual_step = kInfinity;
    int blocking = -1;
    for (int k = 0; k < q; ++k) {
      if (!(r_[k] > 0 && r_[k] * r_[k] * norms2_[k] > kNegligible * kNegligible * norm2)) continue;
      const double step = std::max(u_[k], 0.0) / r_[k];
      if (step < dual_step) dual_step = step, blocking = k;
    }
    normal = 0;
    for (int c = q; c < p; ++c) normal += d_[c] * d_[c];
    const bool dependent = !(normal > kDependent * kDependent * norm2);
    const double primal_step = dependent ? kInfinity : -slack / normal;
    const double step = std::min(primal_step, dual_step);
    if (step == kInfinity) return {QpStatus::kInfeasible, constraint};
    for (int k = 0; k < q; ++k) u_[k] -= step * r_[k];
    multiplier += step;
    if (!dependent) {
      for (int i = 0; i < N; i += 4) *PacketAt(z_.data() + i) = Lanes{};
      AddZ(d_.data(), q, p, z_.data(), n);
      AddColumn(z_.data(), step, x_.data(), 0, N);
      slack = (1 - step / primal_step) * slack;
    }
    if (primal_step <= dual_step) break;
    Drop(blocking, n);
  }
  // The reflection of the remaining part of d changes Z's columns to Z - tau (Z d - alpha z_q) w^T with
  // w = d - alpha e_q.
  const int q = num_active_;
  const double length = std::sqrt(normal), alpha = d_[q] > 0 ? -length : length;
  double* const Z = Z_.data();
  AddColumn(Z + q * N, -alpha, z_.data(), 0, N);
  Copy(d_.data(), R_.data() + q * N, 0, Padded(q));
  d_[q] -= alpha;
  const double tau = 1 / (length * std::abs(d_[q]));
  for (int c = q; c < p; ++c) AddColumn(z_.data(), -tau * d_[c], Z + c * N, 0, N);
  R_[q * N + q] = alpha;
  inverse_[q] = 1 / alpha;
  norms2_[q] = norm2;
  active_[q] = constraint;
  is_active_[constraint] = 1;
  u_[q] = multiplier;
  ++num_active_;
  return {QpStatus::kSolved};
}

// Removes a column from R, and restores the triangular form of R by rotations, which are also applied to Z
// and d.
template <class Size>
TENON_INLINE void DualActiveSet::Drop(int position, Size n) {
  const int N = Padded(n);
  double* const R = R_.data();
  is_active_[active_[position]] = 0;
  --num_active_;
  for (int k = position; k < num_active_; ++k) {
    for (int i = 0; i < k + 2; ++i) R[k * N + i] = R[(k + 1) * N + i];
    norms2_[k] = norms2_[k + 1];
    active_[k] = active_[k + 1];
    u_[k] = u_[k + 1];
  }
  for (int k = position; k < num_active_; ++k) {
    const double a = R[k * N + k], b = R[k * N + k + 1], length = std::sqrt(a * a + b * b);
    const double cosine = a / length, sine = b / length;
    const auto rotate = [&](double& first, double& second) {
      const double turned = cosine * first + sine * second;
      second = cosine * second - sine * first;
      first = turned;
    };
    for (int c = k; c < num_active_; ++c) rotate(R[c * N + k], R[c * N + k + 1]);
    rotate(d_[k], d_[k + 1]);
    double* const z = Z_.data() + k * N;
    for (int i = 0; i < N; i += 4) {
      const Lanes turned = *PacketAt(z + i) * cosine + *PacketAt(z + N + i) * sine;
      *PacketAt(z + N + i) = *PacketAt(z + N + i) * cosine - *PacketAt(z + i) * sine;
      *PacketAt(z + i) = turned;
    }
    inverse_[k] = 1 / R[k * N + k];
  }
}

}  // namespace tenon
