#include <tenon/controllers/optimization/dual_active_set.h>

#include <fmt/core.h>

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <limits>

#include <tenon/controllers/optimization/infinity.h>
#include <tenon/systems/framework/errors.h>

namespace tenon {
namespace {

// A column of V counts as dependent on the others if this part of it, or less, is normal to them: a violated
// constraint is then in conflict, a guessed one, which may come back later, is left out.
constexpr double kDependent = 1e-10, kDependentGuess = 1e-6;
constexpr double kNegligible = 1e-13;

auto Row(const QuadraticProgram& qp, int constraint) {
  const int equalities = static_cast<int>(qp.b_eq.size());
  return constraint < equalities ? qp.A_eq.row(constraint) : qp.A_in.row(constraint - equalities);
}

double Bound(const QuadraticProgram& qp, int constraint) {
  const Eigen::Index equalities = qp.b_eq.size();
  return constraint < equalities ? qp.b_eq[constraint] : qp.b_in[constraint - equalities];
}

// The reflection I - w w^T takes `v` to (alpha, 0, ..., 0). Returns alpha, and w in `v`.
template <class Vector>
double MakeReflector(Vector&& v) {
  const double norm = v.norm();
  if (norm == 0) return 0;
  const double alpha = v[0] > 0 ? -norm : norm;
  v[0] -= alpha;
  v /= std::sqrt(norm * std::abs(v[0]));
  return alpha;
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
    : max_constraints_(max_constraints), max_iterations_(max_iterations) {
  if (max_variables <= 0 || max_constraints < 0 || max_iterations <= 0) {
    throw ParameterError(
        fmt::format("DualActiveSet of {} variables, {} constraints and {} iterations: variables and "
                    "iterations must be positive, constraints not negative",
                    max_variables, max_constraints, max_iterations));
  }
  const int n = max_variables, m = max_constraints;
  for (Eigen::MatrixXd* matrix : {&R_, &reflectors_, &Q_}) matrix->setZero(n, n);
  L_.setZero(n, n);
  for (Eigen::VectorXd* v : {&column_norms_, &x_, &u_, &b_, &residual_, &v_, &d_, &w_, &r_, &dx_, &du_})
    v->setZero(n);
  for (Eigen::VectorXd* v : {&multipliers_, &slack_, &row_norms_}) v->setZero(m);
  first_.resize(static_cast<std::size_t>(n));
  ends_.resize(static_cast<std::size_t>(n));
  active_.resize(static_cast<std::size_t>(n));
  active_inequalities_.reserve(static_cast<std::size_t>(n));
  guess_.reserve(static_cast<std::size_t>(n));
  is_active_.resize(static_cast<std::size_t>(m));
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
      n > 0 && n <= x_.size() && equalities + inequalities <= max_constraints_,
      fmt::runtime("QP: {} variables and {} constraints, but the solver was made for 1 to {} and up to {}; "
                   "make it larger"),
      n, equalities + inequalities, x_.size(), max_constraints_);
}

// Returns the row that is not positive definite, or -1.
int DualActiveSet::FactorCost(const QuadraticProgram& qp) {
  for (int i = 0; i < n_; ++i) {
    int first = 0;
    while (first < i && qp.H(i, first) == 0) ++first;
    first_[i] = first;
    auto row = L_.row(i);
    double diagonal = qp.H(i, i);
    const double scale = diagonal;
    for (int j = first; j < i; ++j) {
      const int from = std::max(first, first_[j]);
      const double dot = from < j ? row.segment(from, j - from).dot(L_.row(j).segment(from, j - from)) : 0;
      row[j] = (qp.H(i, j) - dot) * L_(j, j);
      diagonal -= row[j] * row[j];
    }
    if (!(diagonal > kNegligible * scale)) return i;
    row[i] = 1 / std::sqrt(diagonal);
  }
  return -1;
}

void DualActiveSet::SolveL(Eigen::VectorXd& v) const {
  for (int i = 0; i < n_; ++i) {
    const int first = first_[i], count = i - first;
    if (count > 0) v[i] -= L_.row(i).segment(first, count).dot(v.segment(first, count));
    v[i] *= L_(i, i);
  }
}

void DualActiveSet::SolveLTransposed(Eigen::VectorXd& v) const {
  for (int i = n_ - 1; i >= 0; --i) {
    v[i] *= L_(i, i);
    const int first = first_[i], count = i - first;
    if (count > 0) v.segment(first, count) -= v[i] * L_.row(i).segment(first, count).transpose();
  }
}

void DualActiveSet::ApplyQTransposed(Eigen::VectorXd& v) {
  if (q_is_formed_) {
    r_.head(n_).noalias() = Q_.topLeftCorner(n_, n_).transpose() * v.head(n_);
    v.head(n_) = r_.head(n_);
    return;
  }
  for (int k = 0; k < num_active_; ++k) {
    const auto w = Reflector(k);
    auto part = v.segment(k, w.size());
    part -= w.dot(part) * w;
  }
}

void DualActiveSet::ApplyQ(Eigen::VectorXd& v) {
  if (q_is_formed_) {
    r_.head(n_).noalias() = Q_.topLeftCorner(n_, n_) * v.head(n_);
    v.head(n_) = r_.head(n_);
    return;
  }
  for (int k = num_active_ - 1; k >= 0; --k) {
    const auto w = Reflector(k);
    auto part = v.segment(k, w.size());
    part -= w.dot(part) * w;
  }
}

void DualActiveSet::FormQ() {
  if (q_is_formed_) return;
  Q_.topLeftCorner(n_, n_).setIdentity();
  for (int k = num_active_ - 1; k >= 0; --k) {
    const auto w = Reflector(k);
    auto block = Q_.block(k, k, w.size(), n_ - k);
    auto row = r_.head(n_ - k);
    row.noalias() = block.transpose() * w;
    block.noalias() -= w * row.transpose();
  }
  q_is_formed_ = true;
}

// Makes a constraint active, as next column of the factorisation by reflectors. False if it depends on
// those that are.
bool DualActiveSet::Append(const QuadraticProgram& qp, int constraint, double independence) {
  const int k = num_active_;
  if (k == n_) return false;
  v_.head(n_) = Row(qp, constraint);
  SolveL(v_);
  const double norm = v_.head(n_).norm();
  ApplyQTransposed(v_);
  int end = n_;
  while (end > k + 1 && v_[end - 1] == 0) --end;
  auto tail = v_.segment(k, end - k);
  if (!(tail.norm() > independence * norm)) return false;
  R_(k, k) = MakeReflector(tail);
  R_.col(k).head(k) = v_.head(k);
  reflectors_.col(k).segment(k, end - k) = tail;
  ends_[static_cast<std::size_t>(k)] = end;
  column_norms_[k] = norm;
  active_[k] = constraint;
  is_active_[constraint] = 1;
  ++num_active_;
  return true;
}

// Fresh factors of the equalities and of what is good of the guess; x and the multipliers that belong to it.
void DualActiveSet::Start(const QuadraticProgram& qp) {
  num_active_ = 0;
  q_is_formed_ = false;
  std::fill(is_active_.begin(), is_active_.end(), 0);
  for (int e = 0; e < num_equalities_; ++e) Append(qp, e, kDependent);
  num_active_equalities_ = num_active_;
  for (const int constraint : guess_)
    if (is_active_[constraint] == 0) Append(qp, constraint, kDependentGuess);
  while (true) {
    for (int k = 0; k < num_active_; ++k) b_[k] = Bound(qp, active_[k]);
    SolveActive(qp.g);
    x_.head(n_) = dx_.head(n_);
    u_.head(num_active_) = du_.head(num_active_);
    int kept = num_active_equalities_;
    while (kept < num_active_ && u_[kept] >= 0) ++kept;
    const int before = num_active_;
    num_active_ = kept;
    for (int k = kept; k < before; ++k) is_active_[active_[k]] = 0;
    for (int k = kept; k < before; ++k)
      if (u_[k] >= 0) Append(qp, active_[k], kDependentGuess);
    if (kept == before) return;
  }
}

// dx_ and du_, which minimise 1/2 dx^T H dx + g^T dx with A dx = b_ for the active constraints.
void DualActiveSet::SolveActive(const Eigen::Ref<const Eigen::VectorXd>& g) {
  const int q = num_active_;
  const auto R = R_.topLeftCorner(q, q).triangularView<Eigen::Upper>();
  w_.head(n_) = g;
  SolveL(w_);
  ApplyQTransposed(w_);
  dx_.head(q) = b_.head(q);
  R.transpose().solveInPlace(dx_.head(q));
  du_.head(q) = dx_.head(q) + w_.head(q);
  R.solveInPlace(du_.head(q));
  dx_.segment(q, n_ - q) = -w_.segment(q, n_ - q);
  ApplyQ(dx_);
  SolveLTransposed(dx_);
}

int DualActiveSet::MostViolated(const QuadraticProgram& qp) {
  const int inequalities = num_inequalities_;
  slack_.head(inequalities) = -qp.b_in;
  slack_.head(inequalities).noalias() += qp.A_in * x_.head(n_);
  const double size = x_.head(n_).norm();
  int worst = -1;
  double distance = 0;
  for (int i = 0; i < inequalities; ++i) {
    const double norm = row_norms_[num_equalities_ + i];
    if (slack_[i] >= -kTolerance * (std::abs(qp.b_in[i]) + norm * size)) continue;
    if (is_active_[num_equalities_ + i] != 0) continue;
    const double here = norm > 0 ? slack_[i] / norm : -kInfinity;
    if (here < distance) worst = num_equalities_ + i, distance = here;
  }
  return worst;
}

// Steps 2 of the paper: raises the multiplier of a violated constraint until it is met, dropping what would
// get a negative multiplier on the way.
DualActiveSet::Outcome DualActiveSet::AddViolated(const QuadraticProgram& qp, int constraint,
                                                  int* iterations) {
  FormQ();
  v_.head(n_) = Row(qp, constraint);
  const double bound = Bound(qp, constraint);
  double slack = v_.head(n_).dot(x_.head(n_)) - bound;
  SolveL(v_);
  const double norm = v_.head(n_).norm();
  double multiplier = 0;
  while (true) {
    if (*iterations == max_iterations_) return {QpStatus::kIterationLimit, constraint};
    ++*iterations;
    const int q = num_active_;
    d_.head(n_).noalias() = Q_.topLeftCorner(n_, n_).transpose() * v_.head(n_);
    r_.head(q) = d_.head(q);
    R_.topLeftCorner(q, q).triangularView<Eigen::Upper>().solveInPlace(r_.head(q));
    double dual_step = kInfinity;
    int blocking = -1;
    for (int k = num_active_equalities_; k < q; ++k) {
      if (!(r_[k] * column_norms_[k] > kNegligible * norm)) continue;
      const double step = std::max(u_[k], 0.0) / r_[k];
      if (step < dual_step) dual_step = step, blocking = k;
    }
    const double normal = d_.segment(q, n_ - q).squaredNorm();
    const bool dependent = !(std::sqrt(normal) > kDependent * norm);
    const double primal_step = dependent ? kInfinity : -slack / normal;
    const double step = std::min(primal_step, dual_step);
    if (step == kInfinity) return {QpStatus::kInfeasible, constraint};
    u_.head(q) -= step * r_.head(q);
    multiplier += step;
    if (!dependent) {
      w_.head(n_).noalias() = Q_.block(0, q, n_, n_ - q) * d_.segment(q, n_ - q);
      SolveLTransposed(w_);
      x_.head(n_) += step * w_.head(n_);
      slack = (1 - step / primal_step) * slack;
    }
    if (primal_step <= dual_step) break;
    Drop(blocking);
  }
  const int q = num_active_;
  auto tail = d_.segment(q, n_ - q);
  auto Q2 = Q_.block(0, q, n_, n_ - q);
  R_.col(q).head(q) = d_.head(q);
  R_(q, q) = MakeReflector(tail);
  w_.head(n_).noalias() = Q2 * tail;
  Q2.noalias() -= w_.head(n_) * tail.transpose();
  column_norms_[q] = norm;
  active_[q] = constraint;
  is_active_[constraint] = 1;
  u_[q] = multiplier;
  ++num_active_;
  return {QpStatus::kSolved};
}

// Takes a column out of R, and makes R triangular again by rotations.
void DualActiveSet::Drop(int position) {
  is_active_[active_[position]] = 0;
  --num_active_;
  for (int k = position; k < num_active_; ++k) {
    R_.col(k).head(k + 2) = R_.col(k + 1).head(k + 2);
    column_norms_[k] = column_norms_[k + 1];
    active_[k] = active_[k + 1];
    u_[k] = u_[k + 1];
  }
  for (int k = position; k < num_active_; ++k) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(R_(k, k), R_(k + 1, k));
    auto rows = R_.block(0, k, n_, num_active_ - k);
    rows.applyOnTheLeft(k, k + 1, rotation.adjoint());
    auto columns = Q_.topRows(n_);
    columns.applyOnTheRight(k, k + 1, rotation);
  }
}

// Corrects x and the multipliers until their residuals are within the tolerance. Returns how often, or -1.
int DualActiveSet::Refine(const QuadraticProgram& qp) {
  constexpr int kMaxCorrections = 3;
  const int q = num_active_;
  for (int corrections = 0;; ++corrections) {
    auto pull = w_.head(n_), residual = residual_.head(n_);
    pull.setZero();
    for (int k = 0; k < q; ++k) pull += u_[k] * Row(qp, active_[k]).transpose();
    residual.noalias() = qp.H.selfadjointView<Eigen::Lower>() * x_.head(n_);
    const double scale = residual.cwiseAbs().maxCoeff() + qp.g.cwiseAbs().maxCoeff();
    residual += qp.g - pull;
    bool good = residual.cwiseAbs().maxCoeff() <= kTolerance * (scale + pull.cwiseAbs().maxCoeff());
    const double size = x_.head(n_).norm();
    for (int k = 0; k < q; ++k) {
      const double bound = Bound(qp, active_[k]);
      b_[k] = bound - Row(qp, active_[k]).dot(x_.head(n_));
      good = good && std::abs(b_[k]) <= kTolerance * (std::abs(bound) + row_norms_[active_[k]] * size);
    }
    if (good) return corrections;
    if (corrections == kMaxCorrections) return -1;
    SolveActive(residual);
    x_.head(n_) += dx_.head(n_);
    u_.head(q) += du_.head(q);
  }
}

DualActiveSet::Outcome DualActiveSet::Iterate(const QuadraticProgram& qp, int* iterations) {
  for (int e = 0; e < num_equalities_; ++e) {
    if (is_active_[e] != 0) continue;  // the others depend on these: met if they do not contradict them
    const double residual = qp.A_eq.row(e).dot(x_.head(n_)) - qp.b_eq[e];
    const double scale = std::abs(qp.b_eq[e]) + row_norms_[e] * x_.head(n_).norm();
    if (!(std::abs(residual) <= 10 * kTolerance * scale)) return {QpStatus::kInfeasible, e};
  }
  while (true) {
    const int violated = MostViolated(qp);
    if (violated >= 0) {
      const Outcome outcome = AddViolated(qp, violated, iterations);
      if (outcome.status != QpStatus::kSolved) return outcome;
      continue;
    }
    const int corrections = Refine(qp);
    if (corrections < 0) return {QpStatus::kInaccurate};
    if (corrections > 0) continue;
    const double largest = num_active_ > 0 ? u_.head(num_active_).cwiseAbs().maxCoeff() : 0;
    for (int k = num_active_equalities_; k < num_active_; ++k)
      if (u_[k] < -kTolerance * largest) return {QpStatus::kInaccurate, active_[k]};
    return {QpStatus::kSolved};
  }
}

QpReport DualActiveSet::Solve(const QuadraticProgram& qp, std::span<const int> guess) {
  CheckSizes(qp);
  n_ = static_cast<int>(qp.g.size());
  num_equalities_ = static_cast<int>(qp.b_eq.size());
  num_inequalities_ = static_cast<int>(qp.b_in.size());
  QpReport report;
  // What is not finite shows in the norms of rows, and keeps H from being factored.
  for (int i = 0; i < num_equalities_ + num_inequalities_; ++i) row_norms_[i] = Row(qp, i).norm();
  const double numbers =
      row_norms_.head(num_equalities_ + num_inequalities_).sum() + qp.g.sum() + qp.b_eq.sum() + qp.b_in.sum();
  if (!std::isfinite(numbers)) {
    report.status = QpStatus::kNotFinite;
    return report;
  }
  report.constraint = FactorCost(qp);
  if (report.constraint >= 0) {
    report.status = qp.H.allFinite() ? QpStatus::kNotConvex : QpStatus::kNotFinite;
    return report;
  }
  guess_.clear();
  for (const int i : guess)
    if (i >= 0 && i < num_inequalities_ && guess_.size() < active_.size())
      guess_.push_back(num_equalities_ + i);

  // A failure may be the fault of updated factors: the second time it counts.
  for (report.restarts = 0;; ++report.restarts) {
    Start(qp);
    const Outcome outcome = Iterate(qp, &report.iterations);
    report.status = outcome.status;
    report.constraint = outcome.constraint;
    if (report.ok() || report.status == QpStatus::kIterationLimit || report.restarts == 1) break;
    guess_.assign(active_.begin() + num_active_equalities_, active_.begin() + num_active_);
  }
  if (!report.ok()) return report;
  multipliers_.setZero();
  active_inequalities_.clear();
  for (int k = 0; k < num_active_; ++k) {
    multipliers_[active_[k]] = u_[k];
    if (k >= num_active_equalities_) active_inequalities_.push_back(active_[k] - num_equalities_);
  }
  return report;
}

}  // namespace tenon
