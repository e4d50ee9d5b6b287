#pragma once

#include <tenon/controllers/cdpr/cdpr_plan.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/diagonal_gains.h>

namespace tenon {

/// Weights of the squared errors, per second of the horizon.
struct CdprMpcWeights {
  Vec<3> position = Vec<3>::Zero();  ///< weights of the errors of the CoM's position [1/m^2]
  Vec<3> velocity = Vec<3>::Zero();  ///< weights of the errors of the CoM's velocity [s^2/m^2]
  Vec<3> attitude = Vec<3>::Zero();  ///< weights of the errors of roll, pitch and yaw [1/rad^2]
  /// weights of the errors of the angular velocity about the principal axes [s^2/rad^2]
  Vec<3> angular_velocity = Vec<3>::Zero();
  /// weights of the tensions' deviations from their references, or from 0 [1/N^2]
  DiagonalGains tension = 0;

  static FieldList Fields() {
    using W = CdprMpcWeights;
    return {
        Required("position_per_m2", &W::position)
            .AtLeast(0)
            .Uniform()
            .Scaled("position_l2", [](double w, const Scale& s) { return w / (s.length * s.length); }),
        Required("velocity_s2_per_m2", &W::velocity)
            .AtLeast(0)
            .Uniform()
            .Scaled("velocity_l2_per_t2",
                    [](double w, const Scale& s) { return w * s.Time() * s.Time() / (s.length * s.length); }),
        Required("attitude_per_rad2", &W::attitude)
            .AtLeast(0)
            .Uniform()
            .Scaled("attitude_l2_per_a2",
                    [](double w, const Scale& s) { return w * s.arm * s.arm / (s.length * s.length); }),
        Required("angular_velocity_s2_per_rad2", &W::angular_velocity)
            .AtLeast(0)
            .Uniform()
            .Scaled("angular_velocity_l2_per_a2_t2",
                    [](double w, const Scale& s) {
                      return w * s.arm * s.arm * s.Time() * s.Time() / (s.length * s.length);
                    }),
        Required("tension_per_N2", &W::tension)
            .AtLeast(0)
            .Scaled("tension_m2_g2", [](double w, const Scale& s) { return w / (s.Weight() * s.Weight()); })};
  }
};

/// The weights in the form of the solver: L_k and phi of CdprTrackingProblem.
struct CdprMpcCost {
  Vec<12> Q = Vec<12>::Zero();  ///< diagonal, per second
  CableVector R;                ///< diagonal, per second
  Eigen::Matrix<double, 12, 12, Eigen::DontAlign> Q_f = Eigen::Matrix<double, 12, 12>::Zero();
};

enum class TerminalCost {
  kRiccati,  ///< the cost to go of the linear problem at the equilibrium at the start of the path
  kGiven,    ///< `terminal_weights`: diagonal, as in the thesis
};
constexpr auto EnumNames(TerminalCost) {
  return std::array{Named{TerminalCost::kRiccati, "riccati"}, Named{TerminalCost::kGiven, "diagonal"}};
}

struct CdprMpcParams {
  /// The path to follow, and the robot model of the controller.
  std::shared_ptr<const EquilibriumPath> path;
  /// u_des: the tensions of the equilibrium along the path, or zero.
  bool equilibrium_input = true;
  std::optional<double> clearance;        ///< distance to keep from obstacles; empty: none is kept [m]
  std::optional<double> cable_clearance;  ///< distance to keep between cables; empty: none is kept [m]
  double horizon = 1;                     ///< [s], a multiple of the period
  /// Steps of the horizon: the first is one period, the others grow geometrically, rounded to periods.
  int num_steps = 25;
  CdprMpcWeights weights;
  /// Weight of the state at the end of the horizon; `diagonal` is `terminal_weights`.
  TerminalCost terminal = TerminalCost::kRiccati;
  CdprMpcWeights terminal_weights;  ///< times one second; its `tension` is not used
  SlqOptions slq;
  Rate rate = Hz(100);              ///< rate of the solves
  Rate command_rate = Hz(1000);     ///< rate of the feedback along the plan
  int max_fallbacks_in_a_row = 50;  ///< number of consecutive failed solves above which the run ends
  double unheld_time = 0.2;         ///< time for which the intact cables may fail to hold the platform [s]

  void Validate() const;  ///< throws ParameterError, also if the Riccati equation has no solution
};

/// One solve of CdprMpc: reference, warm start, Slq. Holds only work space.
///
/// The reference at a node is the quasi-static one of the path, corrected for the acceleration of the
/// platform and for its load, see BalancedReference (for u_des = 0, only the attitude is corrected). The
/// tensions at node k are bounded by [t_min, t_max] and by [t_min, t_max] + b dl/dt, with the reel damping b
/// of the winches. Distances are kept as CdprTrackingProblem says, with one update of their multipliers per
/// call. A broken cable has tension 0. Moving anchors have the places that they will have at the
/// time of the node.
class CdprMpcSolver {
 public:
  explicit CdprMpcSolver(const CdprMpcParams& params);
  CdprMpcSolver(const CdprMpcSolver& other);
  CdprMpcSolver& operator=(const CdprMpcSolver& other);
  ~CdprMpcSolver();

  /// The steps h_k in periods, see CdprMpcParams.
  static std::vector<int> Steps(const CdprMpcParams& params);
  /// The plan to rest at the start of the path, without feedback.
  static CdprPlan FirstPlan(const CdprMpcParams& params);

  /// The cost by these weights in place of those of `params`.
  /// @throws ParameterError if the Riccati equation at the start of the path has no solution.
  static CdprMpcCost Cost(const CdprMpcParams& params, const CdprMpcWeights& weights,
                          const CdprMpcWeights& terminal_weights);

  /// Replaces the path by another one of the same robot.
  void Follow(const std::shared_ptr<const EquilibriumPath>& path);

  /// Turns `plan`, made at plan.start, into the plan for a platform at x at `time`. x is the state with the
  /// payload, see CentroidalStateOf(); the rest of the load is assumed constant over the horizon. `broken`
  /// has a 1 for each broken cable, else 0; if it is empty, none is broken.
  SlqReport Solve(double time, const CentroidalState& x, const LoadEstimate& load, const CableVector& broken,
                  const CdprMpcCost& cost, CdprPlan& plan);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon
