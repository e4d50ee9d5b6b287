#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/controllers/optimization/lanes/dual_active_set_steps.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

namespace tenon {
namespace {

bool AllFinite(const QuadraticProgram& qp) {
  for (Eigen::Index j = 0; j < qp.H.cols(); ++j)
    if (!qp.H.col(j).tail(qp.H.rows() - j).allFinite()) return false;
  return qp.g.allFinite() && qp.A_eq.allFinite() && qp.b_eq.allFinite() && qp.A_in.allFinite() &&
         qp.b_in.allFinite();
}

}  // namespace

std::string QpReport::Message() const {
  switch (status) {
    case QpStatus::kSolved:
      return "solved";
    case QpStatus::kInfeasible:
      return fmt::format("constraint {} (equalities first) cannot be met together with the others; relax one",
                         constraint);
    case QpStatus::kNotConvex:
      return fmt::format("H is not positive definite, as its row {} shows; add to its diagonal", constraint);
    case QpStatus::kNotFinite:
      return "a number of the problem is NaN or infinite; leave out constraints that bound nothing";
    case QpStatus::kIterationLimit:
      return fmt::format("no end after {} iterations; raise max_iterations", iterations);
    case QpStatus::kInaccurate:
      return "the solution does not meet the tolerance; scale variables and constraints to similar sizes";
  }
  return {};
}

DualActiveSet::DualActiveSet(int max_variables, int max_constraints, int max_iterations)
    : max_variables_(max_variables),
      max_constraints_(max_constraints),
      max_iterations_(max_iterations),
      cost_(std::max(max_variables, 0)) {
  if (max_variables <= 0 || max_constraints < 0 || max_iterations <= 0) {
    throw ParameterError(
        fmt::format("DualActiveSet of {} variables, {} constraints and {} iterations: variables and "
                    "iterations must be positive, constraints not negative",
                    max_variables, max_constraints, max_iterations));
  }
  const int n = Padded(max_variables), m = Padded(max_constraints);
  for (Numbers* matrix : {&reflectors_, &R_equalities_, &R_, &Z_}) matrix->Resize(n * n);
  for (Numbers* matrix : {&columns_, &work_}) matrix->Resize((m + 1) * n + 4);
  for (Numbers* v : {&tau_, &inverse_alpha_, &inverse_, &y_, &y_equalities_, &slope_, &slope_equalities_, &x_,
                     &u_, &g_, &row_, &residual_, &pull_, &d_, &r_, &z_, &w_})
    v->Resize(n);
  for (Numbers* v :
       {&norms2_, &bounds_, &work_bounds_, &lambda_, &multipliers_, &slack_, &misses_, &lengths2_})
    v->Resize(m + 4);
  transposed_.Resize(n * m);
  const auto rows = static_cast<std::size_t>(m);
  for (std::vector<int>* list : {&active_, &column_ends_, &violated_}) list->resize(rows);
  for (std::vector<int>* list : {&ends_, &independent_, &active_inequalities_, &guess_})
    list->resize(static_cast<std::size_t>(n));
  is_active_.resize(rows);
}

void DualActiveSet::CheckSizes(const QuadraticProgram& qp) const {
  const auto demand = [](bool condition, const auto& text, const auto&... numbers) {
    if (!condition) throw ParameterError(fmt::format(text, numbers...));
  };
  const auto n = qp.g.size(), equalities = qp.b_eq.size(), inequalities = qp.b_in.size();
  demand(qp.H.rows() == n && qp.H.cols() == n, fmt::runtime("QP: H is {} x {}, but g has {} elements"),
         qp.H.rows(), qp.H.cols(), n);
  demand(qp.A_eq.rows() == equalities && (equalities == 0 || qp.A_eq.cols() == n),
         fmt::runtime("QP: A_eq is {} x {}, but b_eq has {} elements and g has {}"), qp.A_eq.rows(),
         qp.A_eq.cols(), equalities, n);
  demand(qp.A_in.rows() == inequalities && (inequalities == 0 || qp.A_in.cols() == n),
         fmt::runtime("QP: A_in is {} x {}, but b_in has {} elements and g has {}"), qp.A_in.rows(),
         qp.A_in.cols(), inequalities, n);
  demand(
      n > 0 && n <= max_variables_ && equalities + inequalities <= max_constraints_,
      fmt::runtime("QP: {} variables and {} constraints, but the solver was made for 1 to {} and up to {}; "
                   "make it larger"),
      n, equalities + inequalities, max_variables_, max_constraints_);
}

// Collects the violated inequalities, the worst first. Returns false if a number is not finite.
template <class Size>
TENON_INLINE bool DualActiveSet::FindViolated(const QuadraticProgram& qp, Size n) {
  num_violated_ = 0;
  const int count = num_inequalities_;
  const double* const b = qp.b_in.data();
  double* const slack = slack_.data();
  if (z_is_formed_)
    MultiplyColumns(x_.data(), n, slack);
  else
    Products(qp.A_in.data(), qp.A_in.outerStride(), count, x_.data(), n, slack);
  int i = 0;
  for (; i + 4 <= count; i += 4) *PacketAt(slack + i) -= *PacketAt(b + i);
  for (; i < count; ++i) slack[i] -= b[i];
  for (; i < Padded(count); ++i) slack[i] = 0;
  const double size2 = Dot(x_.data(), x_.data(), 0, Padded(n));
  Lanes sum = {}, least = {};
  for (i = 0; i < count; i += 4) sum += *PacketAt(slack + i);
  if (!std::isfinite(internal::Sum(sum) + size2)) return false;
  for (int k = 0; k < num_active_; ++k) slack[active_[k] - num_equalities_] = 0;
  for (i = 0; i < count; i += 4) {
    const Lanes here = *PacketAt(slack + i);
    least = least < here ? least : here;
  }
  if (least[0] >= 0 && least[1] >= 0 && least[2] >= 0 && least[3] >= 0) return true;
  double worst = 0;
  for (i = 0; i < count; ++i) {
    if (slack[i] >= 0) continue;
    const double excess = -slack[i] - kTolerance * std::abs(b[i]);
    if (!(excess > 0)) continue;
    if (lengths2_[i] < 0) {
      const double* const row = qp.A_in.data() + i * qp.A_in.outerStride();
      lengths2_[i] = RowProduct(row, row, n);
    }
    const double norm2 = lengths2_[i];
    if (!(excess * excess > kTolerance * kTolerance * norm2 * size2)) continue;
    violated_[num_violated_++] = num_equalities_ + i;
    const double distance2 = norm2 > 0 ? slack[i] * slack[i] / norm2 : kInfinity;
    if (distance2 > worst) {
      worst = distance2;
      std::swap(violated_[0], violated_[num_violated_ - 1]);
    }
  }
  return true;
}

// products = A_in x, from A_in's columns.
template <class Size>
TENON_INLINE void DualActiveSet::MultiplyColumns(const double* x, Size n, double* products) const {
  const int rows = Padded(num_inequalities_);
  for (int i = 0; i < rows; i += 4) *PacketAt(products + i) = Lanes{};
  int c = 0;
  for (; c + 4 <= n; c += 4) AddColumns(transposed_.data() + c * rows, rows, x + c, products, 0, rows);
  for (; c < n; ++c) AddColumn(transposed_.data() + c * rows, x[c], products, 0, rows);
}

// Computes the equalities' multipliers in lambda_ from the factors or, once Z has been updated, from the
// slope that they balance.
template <class Size>
TENON_INLINE void DualActiveSet::SolveEqualityMultipliers(const double* slope, Size n) {
  const int N = Padded(n), e = num_independent_;
  double* const t = d_.data();
  if (z_is_formed_) {
    cost_.MultiplyTransposed(slope, t, n);
    for (int k = 0; k < e; ++k)
      Reflect(reflectors_.data() + k * N, tau_[k], t, N, 1, PaddedDown(k), ends_[k]);
  } else {
    for (int i = 0; i < Padded(e); i += 4)
      *PacketAt(t + i) = *PacketAt(y_equalities_.data() + i) + *PacketAt(slope_.data() + i);
    for (int s = 0; s < num_active_; ++s) AddColumn(columns_.data() + s * N, -u_[s], t, 0, Padded(e));
  }
  for (int i = 0; i < num_equalities_; ++i) lambda_[i] = 0;
  for (int k = e - 1; k >= 0; --k) {
    const double lambda = t[k] * inverse_alpha_[k];
    lambda_[independent_[k]] = lambda;
    AddColumn(R_equalities_.data() + k * N, -lambda, t, 0, Padded(k));
  }
}

// Corrects x and the multipliers until their residuals are within the tolerance. Returns the number of
// corrections, or -1.
template <class Size>
TENON_INLINE int DualActiveSet::Refine(const QuadraticProgram& qp, Size n) {
  constexpr int kMaxCorrections = 3;
  const int N = Padded(n), rows = num_equalities_ + num_active_;
  double* const residual = residual_.data();
  double* const pull = pull_.data();
  for (int corrections = 0;; ++corrections) {
    cost_.Multiply(x_.data(), residual, n);
    const double scale = Largest(residual, N) + Largest(g_.data(), N);
    for (int i = 0; i < N; i += 4) *PacketAt(pull + i) = Lanes{};
    for (int k = 0; k < num_active_; ++k)
      AddProducts(ViewRow(qp, active_[k], num_equalities_).data, 0, 1, &u_.data()[k], pull, n);
    if (num_equalities_ > 0) {
      for (int i = 0; i < N; i += 4)
        *PacketAt(w_.data() + i) = *PacketAt(residual + i) + *PacketAt(g_.data() + i) - *PacketAt(pull + i);
      SolveEqualityMultipliers(w_.data(), n);
      AddProducts(qp.A_eq.data(), qp.A_eq.outerStride(), num_equalities_, lambda_.data(), pull, n);
    }
    for (int i = 0; i < N; i += 4) *PacketAt(residual + i) += *PacketAt(g_.data() + i) - *PacketAt(pull + i);
    bool good = Largest(residual, N) <= kTolerance * (scale + Largest(pull, N));
    const double size2 = Dot(x_.data(), x_.data(), 0, N);
    Products(qp.A_eq.data(), qp.A_eq.outerStride(), num_equalities_, x_.data(), n, misses_.data());
    for (int k = 0; k < num_active_; ++k)
      misses_[num_equalities_ + k] = RowProduct(ViewRow(qp, active_[k], num_equalities_).data, x_.data(), n);
    for (int k = 0; k < rows; ++k) {
      const int constraint = k < num_equalities_ ? k : active_[k - num_equalities_];
      const RowView row = ViewRow(qp, constraint, num_equalities_);
      misses_[k] = row.bound - misses_[k];
      if (k < num_equalities_ && is_active_[k] == 0) continue;
      const double excess = std::abs(misses_[k]) - kTolerance * std::abs(row.bound);
      good = good && (excess <= 0 ||
                      excess * excess <= kTolerance * kTolerance * size2 * RowProduct(row.data, row.data, n));
    }
    if (good) return corrections;
    if (corrections == kMaxCorrections) return -1;
    Correct(qp, n);
  }
}

// Minimises 1/2 dx^T H dx + residual^T dx where the active constraints move by misses_.
template <class Size>
TENON_VECTOR_CLONES void DualActiveSet::Correct(const QuadraticProgram& qp, Size n) {
  FormZ(qp, n);
  const int N = Padded(n), e = num_independent_, q = num_active_, p = n - e;
  double* const s = r_.data();
  double* const dx = z_.data();
  for (int i = 0; i < N; i += 4) *PacketAt(w_.data() + i) = Lanes{};
  for (int k = 0; k < e; ++k) {
    const double sum = Dot(R_equalities_.data() + k * N, w_.data(), 0, Padded(k));
    w_[k] = (misses_[independent_[k]] - sum) * inverse_alpha_[k];
  }
  for (int k = e - 1; k >= 0; --k)
    Reflect(reflectors_.data() + k * N, tau_[k], w_.data(), N, 1, PaddedDown(k), ends_[k]);
  cost_.MultiplyFactor(w_.data(), dx, n);
  for (int k = 0; k < q; ++k) {
    const RowView row = ViewRow(qp, active_[k], num_equalities_);
    s[k] = misses_[num_equalities_ + k] - RowProduct(row.data, dx, n);
    for (int i = 0; i < k; ++i) s[k] -= R_[k * N + i] * s[i];
    s[k] *= inverse_[k];
  }
  MultiplyZTransposed(residual_.data(), d_.data(), n);
  for (int k = 0; k < q; ++k) w_[k] = s[k] + d_[k];
  AddZ(s, 0, q, dx, n);
  for (int c = q; c < p; ++c) d_[c] = -d_[c];
  AddZ(d_.data(), q, p, dx, n);
  SolveR(w_.data(), s, n);
  AddColumn(dx, 1, x_.data(), 0, N);
  for (int k = 0; k < q; ++k) u_[k] += s[k];
}

// Equalities that depend on others are satisfied unless they contradict them. Returns an equality that x does
// not satisfy, or -1.
template <class Size>
TENON_INLINE int DualActiveSet::FindContradiction(const QuadraticProgram& qp, Size n) const {
  if (num_independent_ == num_equalities_) return -1;
  const double size = std::sqrt(Dot(x_.data(), x_.data(), 0, Padded(n)));
  for (int e = 0; e < num_equalities_; ++e) {
    if (is_active_[e] != 0) continue;
    const RowView row = ViewRow(qp, e, num_equalities_);
    const double residual = RowProduct(row.data, x_.data(), n) - row.bound;
    const double scale = std::abs(row.bound) + std::sqrt(RowProduct(row.data, row.data, n)) * size;
    if (!(std::abs(residual) <= 10 * kTolerance * scale)) return e;
  }
  return -1;
}

template <class Size>
TENON_INLINE DualActiveSet::Outcome DualActiveSet::Iterate(const QuadraticProgram& qp, int* iterations,
                                                           Size n) {
  bool at_once = true;
  if (const int e = FindContradiction(qp, n); e >= 0) return {QpStatus::kInfeasible, e};
  while (true) {
    if (!FindViolated(qp, n)) return {QpStatus::kInaccurate};
    const int joining = num_violated_;
    if (joining > 0 && joining <= kFew && at_once && !z_is_formed_) {
      const int before = num_active_;
      const double gain = gain_;
      *iterations += joining;
      if (*iterations > max_iterations_) {
        *iterations = max_iterations_;
        return {QpStatus::kIterationLimit, violated_[0]};
      }
      for (int k = 0; k < joining; ++k) {
        active_[before + k] = violated_[k];
        is_active_[violated_[k]] = 1;
      }
      *iterations += Join(qp, before, before + joining, n);
      at_once = gain_ > (1 + kTolerance) * gain;
      continue;
    }
    if (joining > 0) {
      const Outcome outcome = AddViolated(qp, violated_[0], iterations, n);
      if (outcome.status != QpStatus::kSolved) return outcome;
      continue;
    }
    const int corrections = Refine(qp, n);
    if (corrections < 0) return {QpStatus::kInaccurate};
    if (corrections > 0) continue;
    double largest = 0;
    for (int i = 0; i < num_equalities_; ++i) largest = std::max(largest, std::abs(lambda_[i]));
    for (int k = 0; k < num_active_; ++k) largest = std::max(largest, std::abs(u_[k]));
    for (int k = 0; k < num_active_; ++k)
      if (u_[k] < -kTolerance * largest) return {QpStatus::kInaccurate, active_[k]};
    if (const int e = FindContradiction(qp, n); e >= 0) return {QpStatus::kInfeasible, e};
    return {QpStatus::kSolved};
  }
}

template <class Size>
TENON_VECTOR_CLONES QpReport DualActiveSet::Run(const QuadraticProgram& qp, Size n) {
  QpReport report;
  for (int i = 0; i < n; i += 4) CopyPacket(qp.g.data(), i, n, g_.data());
  for (int i = 0; i < num_inequalities_; i += 4) *PacketAt(lengths2_.data() + i) = Lanes{-1, -1, -1, -1};
  report.constraint = cost_.Factor(qp.H.data(), qp.H.outerStride(), kNegligible, n);
  if (report.constraint >= 0) {
    report.status = QpStatus::kNotConvex;
    return report;
  }
  // Updated factors may have caused a failure, so it counts only after a restart.
  for (report.restarts = 0;; ++report.restarts) {
    Start(qp, n);
    const Outcome outcome = Iterate(qp, &report.iterations, n);
    report.status = outcome.status;
    report.constraint = outcome.constraint;
    if (report.ok() || report.status == QpStatus::kIterationLimit || report.restarts == 1) break;
    num_guess_ = num_active_;
    std::copy_n(active_.begin(), num_guess_, guess_.begin());
  }
  return report;
}

QpReport DualActiveSet::Solve(const QuadraticProgram& qp, std::span<const int> guess) {
  CheckSizes(qp);
  n_ = static_cast<int>(qp.g.size());
  num_equalities_ = static_cast<int>(qp.b_eq.size());
  num_inequalities_ = static_cast<int>(qp.b_in.size());
  num_guess_ = 0;
  for (const int i : guess)
    if (i >= 0 && i < num_inequalities_ && num_guess_ < max_variables_)
      guess_[num_guess_++] = num_equalities_ + i;
  QpReport report = n_ == 12 ? Run(qp, KnownSize<12>()) : Run(qp, n_);
  if (!report.ok()) {
    if (!AllFinite(qp)) report = {.status = QpStatus::kNotFinite};
    return report;
  }
  for (int i = 0; i < num_equalities_; ++i) multipliers_[i] = lambda_[i];
  for (int i = 0; i < num_inequalities_; ++i) multipliers_[num_equalities_ + i] = 0;
  num_solution_ = static_cast<std::size_t>(num_active_);
  for (int k = 0; k < num_active_; ++k) {
    multipliers_[active_[k]] = u_[k];
    active_inequalities_[k] = active_[k] - num_equalities_;
  }
  return report;
}

}  // namespace tenon
