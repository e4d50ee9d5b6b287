#pragma once

#include <tenon/controllers/cdpr/kino_centroidal_model.h>

namespace tenon {

/// The optimal control problem of the cable robot's MPC (Morlando 2023, eqs. (3.10)-(3.17)), for Slq:
///
///     L_k = 1/2 (x - x_des,k)^T Q (x - x_des,k) + 1/2 (u - u_des,k)^T R (u - u_des,k),   Q, R diagonal
///     phi = 1/2 (x - x_des,N)^T Q_f (x - x_des,N)
///     lower_k <= u <= upper_k
///
/// With a payload, the state refers to the common CoM and the weight is a full matrix, see SetErrors().
///
/// n is the number of cables, or Eigen::Dynamic.
template <int n>
class CdprTrackingProblem : public KinoCentroidalModel<n> {
 public:
  using State = CentroidalState;
  using Input = Eigen::Matrix<double, n, 1>;
  using StateMatrix = Eigen::Matrix<double, 12, 12>;

  /// Reference and bounds at a node.
  struct Target {
    State x = State::Zero();
    Input u, lower, upper;  ///< [N]

    explicit Target(int cables) { u = lower = upper = Input::Zero(cables); }
  };

  State Q = State::Zero();  ///< diagonal, per second
  bool coupled = false;     ///< use Q_coupled instead of Q
  StateMatrix Q_coupled = StateMatrix::Zero();
  Input R;  ///< diagonal, per second
  StateMatrix Q_f = StateMatrix::Zero();
  std::vector<Target> targets;  ///< N + 1; only x of the last one is used

  CdprTrackingProblem(const CdprDescription& robot, int num_steps)
      : KinoCentroidalModel<n>(robot),
        R(Input::Zero(robot.num_cables())),
        targets(num_steps + 1, Target(robot.num_cables())) {}

  /// Applies Q and Q_f to T (x - x_des), where T maps errors of the state to errors of the platform alone.
  void SetErrors(const StateMatrix& T) {
    coupled = true;
    Q_coupled = T.transpose() * Q.asDiagonal() * T;
    Q_f = (T.transpose() * Q_f * T).eval();
  }

  double StageCost(int k, const State& x, const Input& u) const {
    const Target& target = targets[k];
    const State error = x - target.x;
    const double of_state = coupled ? error.dot(Q_coupled * error) : error.cwiseAbs2().dot(Q);
    return (of_state + (u - target.u).cwiseAbs2().dot(R)) / 2;
  }
  [[gnu::always_inline]] void AddStageCost(int k, const State& x, const Input& u, double h, State& gx,
                                           Input& gu, StateMatrix& Hxx,
                                           Eigen::Matrix<double, n, n>& Huu) const {
    const Target& target = targets[k];
    if (coupled) {
      gx.noalias() += h * (Q_coupled * (x - target.x));
      Hxx += h * Q_coupled;
    } else {
      for (int i = 0; i < 12; ++i) {
        gx[i] += h * (Q[i] * (x[i] - target.x[i]));
        Hxx(i, i) += h * Q[i];
      }
    }
    for (Eigen::Index i = 0; i < R.size(); ++i) {
      gu[i] += h * (R[i] * (u[i] - target.u[i]));
      Huu(i, i) += h * R[i];
    }
  }
  double TerminalCost(const State& x) const {
    const State error = x - targets.back().x;
    return error.dot(Q_f * error) / 2;
  }
  void AddTerminalCost(const State& x, State& gx, StateMatrix& Hxx) const {
    gx.noalias() += Q_f * (x - targets.back().x);
    Hxx += Q_f;
  }
  const Input& Lower(int k) const { return targets[k].lower; }
  const Input& Upper(int k) const { return targets[k].upper; }
};

}  // namespace tenon
