#pragma once

#include <tenon/controllers/optimization/box_newton.h>
#include <tenon/controllers/optimization/runge_kutta.h>
#include <tenon/systems/framework/types/errors.h>

namespace tenon {

/// An optimal control problem for Slq. The sizes kStates and kInputs are constants or Eigen::Dynamic; k is
/// the index of a node.
///
///     int num_states() const, num_inputs() const;
///     Derivative, Linearize and the type Linearization     f and its Jacobians, see RungeKutta, or the steps
///                                                          themselves, see TakesOwnSteps
///     double StageCost(int k, x, u) const                  L_k [per second]
///     void AddStageCost(int k, x, u, h, gx, gu, Hxx, Huu)  adds h times gradients and Hessians of L_k
///     double TerminalCost(x) const                         phi
///     void AddTerminalCost(x, gx, Hxx) const               adds its gradient and Hessian
///     const Input& Lower(int k) const, Upper(int k) const  bounds of u_k
///
/// Hxx and Huu must be positive semidefinite; for a sum of squares, use the Gauss-Newton approximation.
template <class P>
concept SlqProblem = requires(const P& p, int k, Eigen::Matrix<double, P::kStates, 1>& x,
                              Eigen::Matrix<double, P::kInputs, 1>& u,
                              Eigen::Matrix<double, P::kStates, P::kStates>& Hxx,
                              Eigen::Matrix<double, P::kInputs, P::kInputs>& Huu) {
  requires TakesOwnSteps<P> || GivesJacobians<P>;
  { p.num_states() } -> std::convertible_to<int>;
  { p.num_inputs() } -> std::convertible_to<int>;
  { p.StageCost(k, x, u) } -> std::convertible_to<double>;
  { p.TerminalCost(x) } -> std::convertible_to<double>;
  { p.Lower(k) } -> std::convertible_to<const Eigen::Matrix<double, P::kInputs, 1>&>;
  { p.Upper(k) } -> std::convertible_to<const Eigen::Matrix<double, P::kInputs, 1>&>;
  p.AddStageCost(k, x, u, 0.0, x, u, Hxx, Huu);
  p.AddTerminalCost(x, x, Hxx);
};

/// The policy of Slq at one node: u = u_bar + K (x - x_bar).
template <int n, int m>
struct SlqNode {
  double time = 0;                ///< time from the start of the horizon [s]
  Eigen::Matrix<double, n, 1> x;  ///< nominal state
  Eigen::Matrix<double, m, 1> u;  ///< nominal input
  Eigen::Matrix<double, m, n> K;  ///< feedback
};

/// Sequential linear-quadratic optimal control (Morlando 2023, eqs. (3.10)-(3.18)), in discrete time:
///
///     min  sum_k h_k L_k(x_k, u_k) + phi(x_N),   x_{k+1} = F(x_k, u_k; h_k),   lower_k <= u_k <= upper_k
///
/// with F one Runge-Kutta step of dx/dt = f(x, u), u constant over the step. An iteration
///
/// 1. rolls out the current policy, with its feedback, and linearises all its steps,
/// 2. runs the Riccati recursion backwards: at every node the input's increment du minimises
///    1/2 du^T Huu du + gu^T du over the box, and the feedback is K = -Huu^{-1} Hux on the inputs that are
///    not at a bound, zero on the others; the bounds are ignored if the unconstrained du satisfies them,
/// 3. searches along u = clamp(u_bar + alpha du + K (x - x_bar)) for a sufficient decrease of the cost.
///
/// If the model is not convex or the line search fails, mu I is added to Huu and 2 is repeated. Inputs stay
/// within their bounds in each roll-out; SlqBounds has alternatives.
///
/// The nodes need not be equidistant. Nothing is allocated after construction. Copies are independent, so an
/// Slq can be the Scratch of a block. If a solve fails, see SlqStatus, the policy is unchanged.
template <SlqProblem Problem>
class Slq {
 public:
  static constexpr int n = Problem::kStates, m = Problem::kInputs;
  using State = Eigen::Matrix<double, n, 1>;
  using Input = Eigen::Matrix<double, m, 1>;
  using Node = SlqNode<n, m>;

  /// `steps`: h_k [s], positive. Until SetPolicy() the policy is zero, clamped to the bounds.
  Slq(Problem problem, const std::vector<double>& steps, const SlqOptions& options = {});

  Problem& problem() { return problem_; }
  const Problem& problem() const { return problem_; }
  int num_steps() const { return static_cast<int>(steps_.size()); }

  /// Changes h_0 [s], positive: a horizon whose nodes stay at fixed times while its start moves on.
  void SetFirstStep(double h);
  /// Sets each node to x and u, without feedback.
  void SetPolicy(const State& x, const Input& u);
  /// Shifts the policy by `elapsed` [s]; the last node is repeated at the end.
  void Shift(double elapsed);
  /// Improves the policy for a start at x0 at the first node's time.
  SlqReport Solve(const State& x0);

  /// The N + 1 nodes of the policy; write them for a warm start. The last node repeats input and feedback of
  /// the node before.
  std::vector<Node>& policy() { return policy_; }
  const std::vector<Node>& policy() const { return policy_; }

 private:
  using Tangent = typename RungeKutta<Problem>::Tangent;
  using StateMatrix = Eigen::Matrix<double, n, n>;
  using Gain = Eigen::Matrix<double, m, n>;
  struct Trajectory {
    std::vector<State> x;
    std::vector<Input> u;
    double cost = 0;
  };

  void Clamp(int k, Input& u) const {
    if (options_.bounds == SlqBounds::kNone) return;
    const Input &lower = problem_.Lower(k), &upper = problem_.Upper(k);
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = std::min(std::max(u[i], lower[i]), upper[i]);
  }
  void Advance(int k, const Gain& K, const State& x_bar, Trajectory& trajectory);
  bool Start(const State& x0);  ///< rolls out the policy; the result is nominal_
  bool Backward(double mu);
  bool RollOut(double alpha);  ///< applies alpha increments and feedback to nominal_; result: candidate_
  bool Search(SlqReport& report);
  void Adopt();

  Problem problem_;
  std::vector<double> steps_;
  SlqOptions options_;
  std::vector<Node> policy_;
  Trajectory nominal_, candidate_;
  std::vector<Tangent> tangents_;  // [A B] of every step
  std::vector<Input> increment_;
  std::vector<Gain> gain_;
  double slope_ = 0, curvature_ = 0;  // of the expected cost: alpha slope + alpha^2 curvature

  // Work space of the passes.
  RungeKutta<Problem> step_;
  BoxNewton<m> box_;
  State gx_, Vx_;
  Eigen::Matrix<double, Tangent::ColsAtCompileTime, 1> g_;  // [gx ; gu]
  Input gu_, du_, lower_, upper_;
  StateMatrix V_;
  Tangent VT_;
  Eigen::Matrix<double, Tangent::ColsAtCompileTime, n> transposed_;
  Eigen::Matrix<double, Tangent::ColsAtCompileTime, Tangent::ColsAtCompileTime> H_;
  Eigen::Matrix<double, m, m> Huu_;
  Gain Hux_;
  Eigen::Matrix<double, n, m> Hxu_, Kt_;
  StateMatrix decrease_;
};

}  // namespace tenon

#include <tenon/controllers/optimization/slq_impl.h>
