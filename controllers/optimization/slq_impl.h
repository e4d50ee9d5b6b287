#pragma once

// The bodies of slq.h.

#include <tenon/controllers/optimization/slq.h>

namespace tenon {

template <SlqProblem P>
Slq<P>::Slq(P problem, const std::vector<double>& steps, const SlqOptions& options)
    : problem_(std::move(problem)),
      steps_(steps),
      options_(options),
      step_(problem_.num_states(), problem_.num_inputs()),
      box_(problem_.num_inputs()) {
  const int states = problem_.num_states(), inputs = problem_.num_inputs();
  if (steps_.empty()) throw ParameterError("Slq: there are no steps; give at least one");
  if (options_.max_iterations < 1) throw ParameterError("Slq: max_iterations must be at least 1");
  const std::size_t count = steps_.size();
  policy_.resize(count + 1);
  for (Node& node : policy_) {
    node.x.setZero(states);
    node.u.setZero(inputs);
    node.K.setZero(inputs, states);
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (!(steps_[k] > 0 && std::isfinite(steps_[k])))
      throw ParameterError("Slq: step " + std::to_string(k) + " is " + std::to_string(steps_[k]) +
                           " s; the steps must be positive");
    policy_[k + 1].time = policy_[k].time + steps_[k];
  }
  for (Trajectory* trajectory : {&nominal_, &candidate_}) {
    trajectory->x.resize(count + 1);
    trajectory->u.resize(count);
    for (State& x : trajectory->x) x.setZero(states);
    for (Input& u : trajectory->u) u.setZero(inputs);
  }
  tangents_.resize(count);
  increment_.resize(count);
  gain_.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    tangents_[k].setZero(states, states + inputs);
    increment_[k].setZero(inputs);
    gain_[k].setZero(inputs, states);
  }
  g_.setZero(states + inputs);
  for (State* x : {&gx_, &Vx_}) x->setZero(states);
  for (Input* u : {&gu_, &du_, &lower_, &upper_}) u->setZero(inputs);
  for (StateMatrix* A : {&V_, &decrease_}) A->setZero(states, states);
  VT_.setZero(states, states + inputs);
  transposed_.setZero(states + inputs, states);
  H_.setZero(states + inputs, states + inputs);
  Huu_.setZero(inputs, inputs);
  Hux_.setZero(inputs, states);
  Hxu_.setZero(states, inputs);
  Kt_.setZero(states, inputs);
}

template <SlqProblem P>
void Slq<P>::SetFirstStep(double h) {
  const double change = h - steps_[0];
  steps_[0] = h;
  for (std::size_t k = 1; k < policy_.size(); ++k) policy_[k].time += change;
}

template <SlqProblem P>
void Slq<P>::SetPolicy(const State& x, const Input& u) {
  for (Node& node : policy_) {
    node.x = x;
    node.u = u;
    node.K.setZero();
  }
}

template <SlqProblem P>
void Slq<P>::Shift(double elapsed) {
  // Node i is interpolated from nodes from i on, which are not overwritten yet.
  std::size_t j = 0;
  for (std::size_t i = 0; i + 1 < policy_.size(); ++i) {
    const double time = policy_[i].time + elapsed;
    while (j + 2 < policy_.size() && policy_[j + 1].time <= time) ++j;
    const Node &a = policy_[j], &b = policy_[j + 1];
    const double s = std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
    internal::Interpolate(a.x, b.x, s, policy_[i].x);
    internal::Interpolate(a.u, b.u, s, policy_[i].u);
    internal::Interpolate(a.K, b.K, s, policy_[i].K);
  }
}

// Adds the feedback K (x - x_bar) to the input of `trajectory` at node k and advances it by a step.
template <SlqProblem P>
[[gnu::always_inline]] inline void Slq<P>::Advance(int k, const Gain& K, const State& x_bar,
                                                   Trajectory& trajectory) {
  const State& x = trajectory.x[k];
  Input& u = trajectory.u[k];
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const double error = x[j] - x_bar[j];
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] += K(i, j) * error;
  }
  Clamp(k, u);
  trajectory.cost += steps_[k] * problem_.StageCost(k, x, u);
  step_.Step(problem_, k, options_.method, steps_[k], x, u, trajectory.x[k + 1]);
}

template <SlqProblem P>
TENON_VECTOR_CLONES bool Slq<P>::Start(const State& x0) {
  nominal_.x[0] = x0;
  nominal_.cost = 0;
  for (int k = 0; k < num_steps(); ++k) {
    const Node& node = policy_[k];
    nominal_.u[k] = node.u;
    Advance(k, node.K, node.x, nominal_);
  }
  nominal_.cost += problem_.TerminalCost(nominal_.x.back());
  return std::isfinite(nominal_.cost);
}

template <SlqProblem P>
TENON_VECTOR_CLONES bool Slq<P>::Backward(double mu) {
  const int states = problem_.num_states(), inputs = problem_.num_inputs();
  slope_ = curvature_ = 0;
  Vx_.setZero();
  V_.setZero();
  problem_.AddTerminalCost(nominal_.x.back(), Vx_, V_);
  for (int k = num_steps() - 1; k >= 0; --k) {
    // [A B]^T V [A B] and [A B]^T Vx
    internal::Transpose(tangents_[k], transposed_);
    internal::Multiply(V_, tangents_[k], VT_);
    internal::MultiplyLower(transposed_, VT_, H_);
    internal::Multiply(transposed_, Vx_, g_);
    gx_ = g_.head(states);
    gu_ = g_.tail(inputs);
    for (int c = 0; c < states; ++c) {
      for (int r = 0; r < states; ++r) V_(r, c) = H_(r, c);
      for (int r = 0; r < inputs; ++r) Hux_(r, c) = H_(states + r, c);
    }
    for (int c = 0; c < inputs; ++c)
      for (int r = c; r < inputs; ++r) Huu_(r, c) = Huu_(c, r) = H_(states + r, states + c);
    problem_.AddStageCost(k, nominal_.x[k], nominal_.u[k], steps_[k], gx_, gu_, V_, Huu_);

    Input& du = increment_[k];
    Gain& K = gain_[k];
    for (int i = 0; i < inputs; ++i) Huu_(i, i) += mu;
    if (options_.bounds == SlqBounds::kProjectedNewton) {
      for (int i = 0; i < inputs; ++i) {
        lower_[i] = problem_.Lower(k)[i] - nominal_.u[k][i];
        upper_[i] = problem_.Upper(k)[i] - nominal_.u[k][i];
        du[i] = 0;
      }
      if (!box_.Solve(Huu_, gu_, lower_, upper_, du)) return false;
    } else if (!box_.SolveFree(Huu_, gu_, du)) {
      return false;
    }
    internal::Transpose(Hux_, Hxu_);
    Kt_ = Hxu_;
    box_.Sensitivity(Kt_);
    internal::Transpose(Kt_, K);

    slope_ += gu_.dot(du);
    du_ = Huu_.lazyProduct(du);
    curvature_ += (du.dot(du_) - mu * du.squaredNorm()) / 2;
    // On the free inputs Huu K = -Hux and Huu du = -gu, mu included in Huu; the others have K = 0.
    Vx_ = gx_ + Hux_.transpose().lazyProduct(du);
    if (mu > 0) Vx_ -= mu * K.transpose().lazyProduct(du);
    if (mu > 0) Hxu_ -= mu * Kt_;
    internal::MultiplyLower(Hxu_, K, decrease_);
    for (Eigen::Index i = 0; i < V_.size(); ++i) V_.data()[i] += decrease_.data()[i];
    internal::Mirror(V_);
  }
  return std::isfinite(slope_) && std::isfinite(curvature_);
}

template <SlqProblem P>
TENON_VECTOR_CLONES bool Slq<P>::RollOut(double alpha) {
  candidate_.x[0] = nominal_.x[0];
  candidate_.cost = 0;
  for (int k = 0; k < num_steps(); ++k) {
    Input& u = candidate_.u[k];
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = nominal_.u[k][i] + alpha * increment_[k][i];
    Advance(k, gain_[k], nominal_.x[k], candidate_);
  }
  candidate_.cost += problem_.TerminalCost(candidate_.x.back());
  return std::isfinite(candidate_.cost);
}

template <SlqProblem P>
bool Slq<P>::Search(SlqReport& report) {
  constexpr double kFairPart = 1e-4, kShortest = 1e-3;
  const double rounding = 1e-14 * (1 + std::abs(nominal_.cost));
  for (double alpha = 1; alpha > kShortest; alpha /= 2) {
    const double expected = -alpha * (slope_ + alpha * curvature_);
    if (!RollOut(alpha)) continue;
    if (nominal_.cost - candidate_.cost >= kFairPart * expected - rounding) {
      report.step_length = alpha;
      return true;
    }
  }
  return false;
}

template <SlqProblem P>
void Slq<P>::Adopt() {
  for (int k = 0; k < num_steps(); ++k) {
    policy_[k].x = nominal_.x[k];
    policy_[k].u = nominal_.u[k];
    policy_[k].K = gain_[k];
  }
  policy_.back().x = nominal_.x.back();
  policy_.back().u = nominal_.u.back();
  policy_.back().K = gain_.back();
}

template <SlqProblem P>
SlqReport Slq<P>::Solve(const State& x0) {
  constexpr double kLeastMu = 1e-6, kLargestMu = 1e10, kFactor = 10;
  SlqReport report;
  double mu = 0;
  if (!x0.allFinite() || !Start(x0)) {
    report.status = SlqStatus::kNotFinite;
    return report;
  }
  report.initial_cost = report.cost = nominal_.cost;
  for (;;) {
    step_.Linearize(problem_, options_.method, num_steps(), steps_.data(), nominal_.x.data(),
                    nominal_.u.data(), tangents_.data());
    bool descends = false, converged = false;
    for (; mu <= kLargestMu && !descends; mu = std::max(kLeastMu, kFactor * mu)) {
      if (!Backward(mu)) continue;
      report.regularisation = mu;
      report.expected_reduction = -(slope_ + curvature_);
      converged = report.expected_reduction <= options_.tolerance * (1 + std::abs(nominal_.cost));
      if ((descends = converged || Search(report))) break;
    }
    if (!descends) {
      report.status = SlqStatus::kNoDescent;
      return report;
    }
    mu = mu <= kLeastMu ? 0 : mu / kFactor;
    ++report.iterations;
    if (converged) {
      report.status = SlqStatus::kConverged;
      break;
    }
    std::swap(nominal_, candidate_);
    report.cost = nominal_.cost;
    report.status = SlqStatus::kStepped;
    if (report.iterations >= options_.max_iterations) break;
  }
  Adopt();
  return report;
}

}  // namespace tenon
