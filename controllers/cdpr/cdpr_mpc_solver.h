#pragma once

#include <tenon/controllers/cdpr/cdpr_plan.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/controllers/optimization/slq_options.h>
#include <tenon/systems/framework/block/rate.h>

#include <array>
#include <memory>
#include <vector>

namespace tenon {

/// Weights of the squared errors, per second of the horizon.
struct CdprMpcWeights {
  double position = 0;          ///< of the CoM against the reference [1/m^2]
  double velocity = 0;          ///< of the CoM's velocity [s^2/m^2]
  double attitude = 0;          ///< of roll, pitch and yaw [1/rad^2]
  double angular_velocity = 0;  ///< [s^2/rad^2], about the principal axes of a level platform
  double tension = 0;           ///< of each tension against its reference, or 0 [1/N^2]

  static FieldList Fields() {
    return {Required("position_per_m2", &CdprMpcWeights::position),
            Required("velocity_s2_per_m2", &CdprMpcWeights::velocity),
            Required("attitude_per_rad2", &CdprMpcWeights::attitude),
            Required("angular_velocity_s2_per_rad2", &CdprMpcWeights::angular_velocity),
            Required("tension_per_N2", &CdprMpcWeights::tension)};
  }
};

/// What the weights are to the solver: L_k and phi of CdprTrackingProblem.
struct CdprMpcCost {
  CentroidalState Q = CentroidalState::Zero();  ///< diagonal, per second
  double R = 0;                                 ///< of each tension, per second
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
  /// What to follow, and the robot that the controller believes in.
  std::shared_ptr<const EquilibriumPath> path;
  /// u_des: the tensions of the equilibrium along the path, or zero.
  bool equilibrium_input = true;
  double horizon = 1;  ///< [s], a multiple of the period
  /// Steps of the horizon: the first is one period, the others grow geometrically, rounded to periods.
  int num_steps = 25;
  CdprMpcWeights weights;
  TerminalCost terminal = TerminalCost::kRiccati;
  CdprMpcWeights terminal_weights;  ///< times one second; the tension's is not used
  SlqOptions slq;
  Rate rate = Hz(100);
  Rate command_rate = Hz(1000);
  int max_fallbacks_in_a_row = 50;
  double unheld_time = 0.2;  ///< for so long may cables that are left fail to hold the platform [s]

  void Validate() const;  ///< throws ParameterError, also if the Riccati equation has no solution
};

/// What one solve of CdprMpc is: reference, warm start, Slq. Holds work space only.
///
/// The reference at a node is the quasi-static one of the path, with what it takes to accelerate the platform
/// and to carry its load, see BalancedReference (for u_des = 0 the attitude alone). Bounds of node k leave
/// room for the reel damping b of the winches: tensions at the platform within [t_min, t_max] and
/// [t_min, t_max] + b dl/dt. A cable that is broken has tension 0.
class CdprMpcSolver {
 public:
  explicit CdprMpcSolver(const CdprMpcParams& params);
  CdprMpcSolver(const CdprMpcSolver& other);
  CdprMpcSolver& operator=(const CdprMpcSolver& other);
  ~CdprMpcSolver();

  /// The steps h_k in periods, see CdprMpcParams.
  static std::vector<int> Steps(const CdprMpcParams& params);
  /// To rest at the start of the path, without feedback.
  static CdprPlan FirstPlan(const CdprMpcParams& params);

  /// The cost by these weights in place of those of `params`.
  /// @throws ParameterError if the Riccati equation at the start of the path has no solution.
  static CdprMpcCost Cost(const CdprMpcParams& params, const CdprMpcWeights& weights,
                          const CdprMpcWeights& terminal_weights);

  /// From the next solve on, another path of the same robot.
  void Follow(const std::shared_ptr<const EquilibriumPath>& path);

  /// `plan`, made at plan.start, becomes the plan for a platform at x at `time`, x with its payload (see
  /// CentroidalStateOf), on which the rest of the load stays as it is. `broken` has a 1 for a cable that is,
  /// else 0; without entries none is.
  SlqReport Solve(double time, const CentroidalState& x, const LoadEstimate& load, const CableVector& broken,
                  const CdprMpcCost& cost, CdprPlan& plan);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon
