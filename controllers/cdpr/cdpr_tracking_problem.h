#pragma once

#include <tenon/controllers/cdpr/cdpr_clearance.h>
#include <tenon/controllers/cdpr/kino_centroidal_model.h>
#include <tenon/controllers/optimization/augmented_lagrangian.h>
#include <tenon/plants/signals/euler.h>

namespace tenon {

/// The optimal control problem of the cable robot's MPC (Morlando 2023, eqs. (3.10)-(3.17)), for Slq:
///
///     L_k = 1/2 (x - x_des,k)^T Q (x - x_des,k) + 1/2 (u - u_des,k)^T R (u - u_des,k),   Q, R diagonal
///     phi = 1/2 (x - x_des,N)^T Q_f (x - x_des,N)
///     lower_k <= u <= upper_k
///
/// The path constraints (3.13) are distances of the platform and the cables that are kept at all nodes but
/// the last, see CdprClearance, by an augmented Lagrangian in the stage cost.
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

  CdprClearance clearance;
  Eigen::Vector3d com_B = Eigen::Vector3d::Zero();  ///< the common CoM of platform and payload
  AugmentedLagrangian lagrangian;
  std::vector<CableVector> multipliers;  ///< N + 1 times one for each distance; the last repeats

  CdprTrackingProblem(const CdprDescription& robot, int num_steps, const CdprClearance& kept = {})
      : KinoCentroidalModel<n>(robot),
        R(Input::Zero(robot.num_cables())),
        targets(num_steps + 1, Target(robot.num_cables())),
        clearance(kept),
        multipliers(num_steps + 1, CableVector::Zero(kept.size())) {}

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
    double cost = (of_state + (u - target.u).cwiseAbs2().dot(R)) / 2;
    if (clearance.size() > 0)
      ForEachDistance(k, x, [&](int i, const PoseDistance& distance) {
        cost += lagrangian.Cost(distance.value - distance.kept, multipliers[k][i]);
      });
    return cost;
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
    if (clearance.size() == 0) return;
    const Eigen::Matrix3d E = EulerRateMatrix(x.template tail<3>());
    ForEachDistance(k, x, [&](int i, const PoseDistance& distance) {
      const double next = lagrangian.Multiplier(distance.value - distance.kept, multipliers[k][i]);
      if (next == 0) return;
      Eigen::Matrix<double, 6, 1> gradient;
      gradient << distance.by_position, E.transpose() * distance.by_turn;
      gx.template tail<6>() -= h * next * gradient;
      Hxx.template bottomRightCorner<6, 6>() += h * lagrangian.penalty * gradient * gradient.transpose();
    });
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
  /// Sets the multipliers to the next ones, at the nodes `policy`.
  void UpdateMultipliers(const auto& policy) {
    for (std::size_t k = 0; k + 1 < multipliers.size() && clearance.size() > 0; ++k)
      ForEachDistance(static_cast<int>(k), policy[k].x, [&](int i, const PoseDistance& distance) {
        multipliers[k][i] = lagrangian.Multiplier(distance.value - distance.kept, multipliers[k][i]);
      });
    multipliers.back() = *(multipliers.end() - 2);
  }

 private:
  // Calls visit(i, distance) for the distances at a node. Not inlined, so that problems without constraints
  // stay as fast as they are.
  template <class Visit>
  [[gnu::noinline]] void ForEachDistance(int k, const State& x, const Visit& visit) const {
    const Eigen::Matrix3d R_WB = RotationFromEuler(x.template tail<3>());
    const Eigen::Vector3d com_W = R_WB * com_B;
    int i = 0;
    clearance.ForEach(
        x.template segment<3>(6) - com_W, R_WB, [&](int cable) { return this->ExitOf(cable, k); },
        [&](int, int, PoseDistance distance) {
          distance.by_turn -= com_W.cross(distance.by_position);  // p_WB moves about the CoM
          visit(i++, distance);
        });
  }
};

}  // namespace tenon
