#include <tenon/controllers/legged/planning/trajectory_problem.h>

#include <Eigen/Cholesky>
#include <fmt/core.h>
#include <nlopt.h>

namespace tenon {
namespace {

using Problem = TrajectoryProblem;
using RowMap = Eigen::Map<Eigen::RowVectorXd>;

template <auto Constraints>
void Call(unsigned, double* values, unsigned, const double* z, double* jacobian, void* self) {
  (static_cast<Problem*>(self)->*Constraints)(z, values, jacobian);
}

}  // namespace

void Problem::Prepare() {
  const int K = num_knots();
  int size = 3 * K;
  for (const Knot& knot : knots) size += static_cast<int>(std::ranges::count(knot.carries, true));
  for (const Foothold& foot : feet) size += 2 * foot.chosen;
  constant_.setZero(P(static_cast<int>(feet.size()), 0));
  by_z_.setZero(constant_.size(), size);
  best_.setZero(size);
  auto& [position, speed, weighted, duration, divergent] = memory_;
  position.setZero(K, K);
  speed.setZero(K, K);
  duration.setZero(K);
  for (int k = 0; k + 1 < K; ++k) {
    const double T = knots[k + 1].time - knots[k].time;
    position.row(k + 1) = position.row(k) + T * speed.row(k);
    position(k + 1, k) += T * T / 3;
    position(k + 1, k + 1) += T * T / 6;
    speed.row(k + 1) = speed.row(k);
    speed.block<1, 2>(k + 1, k).array() += T / 2;
    duration.segment<2>(k).array() += T / 2;
  }
  divergent = position.row(K - 1) + speed.row(K - 1);
  for (int axis = 0; axis < 3; ++axis) {
    // The cost is a' H a / 2 - b' a, with H = L L' and a = L^-T y: its minimum is at y = L^-1 b.
    const double weight = axis < 2 ? properties.position_weight : properties.height_weight;
    auto best = best_.segment(axis * K, K);
    auto a_by_y = by_z_.block(A(0, axis), axis * K, K, K);
    Eigen::MatrixXd& L = factor_[axis / 2];
    weighted.noalias() = (weight * duration).asDiagonal() * position;
    L.noalias() = position.transpose() * weighted;
    L.noalias() += properties.final_weight * divergent.transpose() * divergent;
    L.diagonal() += duration;
    for (int k = 0; k < K; ++k) {
      constant_[C(k, axis)] = start[axis] + knots[k].time * velocity[axis];
      const double off = knots[k].path[axis] - constant_[C(k, axis)];
      best += weight * duration[k] * off * position.row(k).transpose();
      if (k == K - 1)
        best += properties.final_weight * (off + end_velocity[axis] - velocity[axis]) * divergent.transpose();
    }
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(L);
    factor.matrixL().solveInPlace(best);
    a_by_y.setIdentity();
    factor.matrixU().solveInPlace(a_by_y);
    by_z_.block(C(0, axis), axis * K, K, K).noalias() = position * a_by_y;
  }
  lower.assign(3 * K, -HUGE_VAL);
  upper.assign(3 * K, HUGE_VAL);
  at_.assign(3 * K, -1);
  const auto add = [&](int u, double value, double lowest, double highest, double weight) {
    constant_[u] = value;
    by_z_(u, static_cast<Eigen::Index>(at_.size())) = 1 / std::sqrt(weight);
    at_.push_back(u);
    lower.push_back((lowest - value) * std::sqrt(weight));
    upper.push_back((highest - value) * std::sqrt(weight));
  };
  for (int k = 0; k < K; ++k)
    for (int i = 0; i < kNumLegs; ++i) {
      const double equal = 1.0 / static_cast<double>(std::ranges::count(knots[k].carries, true));
      if (knots[k].carries[i])
        add(W(k, i), equal, properties.least_load, HUGE_VAL, properties.load_weight * duration[k]);
    }
  for (int f = 0; f < static_cast<int>(feet.size()); ++f)
    for (int axis = 0; axis < 3; ++axis) {
      constant_[P(f, axis)] = feet[f].place[axis];
      if (feet[f].chosen && axis < 2)
        add(P(f, axis), feet[f].place[axis], feet[f].lower[axis], feet[f].upper[axis],
            properties.foothold_weight);
    }
}

const Eigen::VectorXd& Problem::U(const double* z) {
  u_ = constant_;
  u_.noalias() += by_z_ * Eigen::Map<const Eigen::VectorXd>(z, best_.size());
  return u_;
}

void Problem::Guess(const double* u, double* z) const {
  for (int next = 0; next < best_.size(); ++next) {
    const int axis = next / num_knots(), at = at_[next];
    double value = at < 0 ? 0 : (u[at] - constant_[at]) / by_z_(at, next);
    for (int j = next % num_knots(); j < num_knots() && at < 0; ++j)
      value += factor_[axis / 2](j, next % num_knots()) * u[A(j, axis)];
    z[next] = std::clamp(value, lower[next], upper[next]);
  }
}

double Problem::Cost(const double* z, double* gradient) const {
  const Eigen::Map<const Eigen::VectorXd> at(z, best_.size());
  if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, best_.size()) = at - best_;
  return (at - best_).squaredNorm() / 2;
}

void Problem::Equalities(const double* z, double* values, double* jacobian) {
  const Eigen::VectorXd& u = U(z);
  for (int k = 0; k < num_knots(); ++k)
    for (int axis = 0; axis < 3; ++axis, ++values) {
      RowMap row(jacobian, jacobian == nullptr ? 0 : best_.size());
      if (row.size() > 0) row = by_z_.row(A(k, axis));
      jacobian += row.size();
      *values = u[A(k, axis)] + (axis == 2 ? 1 : 0);
      for (int i = 0; i < kNumLegs; ++i) {
        const int place = P(knots[k].foot[i], axis);
        const double arm = u[C(k, axis)] - u[place], load = u[W(k, i)];
        *values -= load * arm;
        if (row.size() > 0)
          row -= load * (by_z_.row(C(k, axis)) - by_z_.row(place)) + arm * by_z_.row(W(k, i));
      }
    }
}

void Problem::Inequalities(const double* z, double* values, double* jacobian) {
  const Eigen::VectorXd& u = U(z);
  for (int k = 0; k < num_knots(); ++k)
    for (int i = -1; i < kNumLegs; ++i, ++values) {  // the cone, then the legs
      RowMap row(jacobian, jacobian == nullptr ? 0 : best_.size());
      row.setZero();
      jacobian += row.size();
      *values = i < 0 ? 0 : knots[k].reaches[i] ? -reach[i] * reach[i] : -1;
      for (int axis = 0; axis < 3 && (i < 0 || knots[k].reaches[i]); ++axis) {
        const int at = i < 0 ? A(k, axis) : C(k, axis), place = i < 0 ? 0 : P(knots[k].foot[i], axis);
        const double part = u[at] + (i >= 0 ? knots[k].hip[i][axis] - u[place] : axis == 2 ? 1 : 0);
        const double factor = i < 0 && axis == 2 ? -friction * friction : 1;
        *values += factor * part * part;
        if (row.size() > 0) row += 2 * factor * part * by_z_.row(at);
        if (row.size() > 0 && i >= 0) row -= 2 * part * by_z_.row(place);
      }
    }
}

std::string Problem::Solve(int max_evaluations, double accuracy, double* z) {
  nlopt_opt solver = nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(best_.size()));
  const int equalities = num_equalities();
  values_.setConstant(equalities + num_inequalities(), accuracy);
  const auto cost = [](unsigned, const double* at, double* gradient, void* self) {
    return static_cast<const Problem*>(self)->Cost(at, gradient);
  };
  nlopt_set_min_objective(solver, cost, this);
  nlopt_add_equality_mconstraint(solver, equalities, &Call<&Problem::Equalities>, this, values_.data());
  nlopt_add_inequality_mconstraint(solver, num_inequalities(), &Call<&Problem::Inequalities>, this,
                                   values_.data());
  nlopt_set_lower_bounds(solver, lower.data());
  nlopt_set_upper_bounds(solver, upper.data());
  nlopt_set_maxeval(solver, max_evaluations);
  nlopt_set_ftol_rel(solver, accuracy);
  double least = 0;
  const nlopt_result result = nlopt_optimize(solver, z, &least);
  evaluations = nlopt_get_numevals(solver);
  nlopt_destroy(solver);
  Equalities(z, values_.data(), nullptr);
  Inequalities(z, values_.data() + equalities, nullptr);
  values_.head(equalities) = values_.head(equalities).cwiseAbs();
  int at = 0;
  const double violation = values_.maxCoeff(&at);
  if (violation <= accuracy) return {};
  const int row = at < equalities ? at : at - equalities, rows = at < equalities ? 3 : 1 + kNumLegs;
  const std::string what = rows == 3 ? "dynamics" : row % rows == 0 ? "friction" : kLegNames[row % rows - 1];
  return fmt::format("the constraint of {} at knot {} is not kept: it is off by {:.2g} ({})", what,
                     row / rows, violation, nlopt_result_to_string(result));
}

}  // namespace tenon
