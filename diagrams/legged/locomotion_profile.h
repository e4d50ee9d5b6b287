#pragma once

#include <tenon/controllers/legged/comparison/nonlinear_disturbance_observer.h>
#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/planning/centroidal_mpc.h>
#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/controllers/legged/planning/step_timing_adapter.h>
#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/controllers/legged/planning/trunk_planner.h>
#include <tenon/controllers/legged/whole_body/whole_body_controller.h>
#include <tenon/systems/io/slow.h>

namespace tenon {

struct RenamedKey;
struct YamlFile;

/// The disturbance estimates that the controller compensates.
enum class ObserverKind {
  kNone,        ///< none: all estimates are zero
  kLegs,        ///< forces on the legs by LegMomentumObserver
  kCom,         ///< net wrench by ComObserver
  kHybrid,      ///< kLegs and kCom
  kFocchi,      ///< net wrench by CentroidalMomentumObserver
  kNdoM,        ///< forces on the legs by NonlinearDisturbanceObserver with NdoReading::kM
  kNdoInverse,  ///< forces on the legs by NonlinearDisturbanceObserver with NdoReading::kInverse
  kNdoHybrid,   ///< kNdoM and kCom
};

/// Parameters of a DisturbanceObserver. `kind` selects the blocks that are made. For kFocchi `focchi`
/// replaces the gains of `com`; `ndo.reading` follows from the kind.
struct DisturbanceObserverParams {
  ObserverKind kind = ObserverKind::kHybrid;
  LegMomentumObserverParams legs;
  ComObserverParams com;
  ComObserverGains focchi = CentroidalMomentumObserver();
  NonlinearDisturbanceObserverParams ndo;
};

/// Parameters of the blocks of a LeggedLocomotion.
struct LeggedLocomotionParams {
  std::optional<PaceProperties> pace;  ///< empty: without a Pacer
  FootSchedulerParams scheduler;
  GroundEstimatorParams ground;
  ComPlannerParams com_planner;
  SwingPlannerParams swing_planner;
  TrunkPlannerParams trunk_planner;
  StepTimingAdapterParams step_timing;
  std::optional<CentroidalMpcProperties> mpc;  ///< empty: a TrunkPlanner instead
  SlowOptions calculation;                     ///< duration of a solve of the MPC
  WholeBodyParams whole_body;
  bool mapped = false;  ///< the planners read an elevation map
};

/// Choice and gains of the observers.
struct ObserverProfile {
  ObserverKind kind = ObserverKind::kHybrid;
  LegObserverGains legs;
  ComObserverGains com;
  ComObserverGains focchi = CentroidalMomentumObserver();  ///< gains of the kind `focchi`
  DiagonalGains ndo_gain = 10;                             ///< gain X of NonlinearDisturbanceObserver

  static FieldList Fields() {
    return {Required("kind", &ObserverProfile::kind),
            Required("legs", &ObserverProfile::legs),
            Required("com", &ObserverProfile::com),
            {"focchi", &ObserverProfile::focchi},
            Required("ndo_gain", &ObserverProfile::ndo_gain).Positive()};
  }
  void Validate() const { ndo_gain.CheckSize("ndo_gain", 12, "joints"); }
};

/// Gains of the walking controller of one robot. Files such as diagrams/profiles/standard.yaml give them for
/// robots of all sizes in the units of RobotScale: m, l, g and t = sqrt(l / g) in a key name these units, as
/// in `com_stiffness_mg_per_l`. The weights of the optimization hold for forces in m g, torques in m g l and
/// accelerations in g. Angles, and rates and accelerations per error, do not depend on the size of the robot.
struct LocomotionProfile {
  WholeBodyGains whole_body;
  double sway_limit = 80;  ///< parameter of the TrunkPlanner [rad/s^2]
  /// CoM velocity error beyond which footholds capture the robot, see SwingPlanner [m/s]
  double capture_speed = std::numeric_limits<double>::infinity();
  StepTiming step_timing;  ///< limits of the StepTimingAdapter
  GroundBelief ground;
  double qp_rate_hz = 1000;
  ObserverProfile observer;

  static FieldList Fields();
  static std::vector<RenamedKey> Renamed();
};

/// Reads a shipped profile, a file, or one with changes (see LoadResource) for a robot of this size. Throws
/// ParameterError.
LocomotionProfile LoadLocomotionProfile(const YamlFile& file, const RobotScale& scale);
/// Reads a shipped table of gaits, a file, or one with changes (see LoadResource) for a robot of this size.
/// Throws ParameterError.
FootSchedulerParams LoadGaits(const YamlFile& file, const RobotScale& scale);

/// Parameters of a LeggedLocomotion with this model of the robot.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot, const LocomotionProfile& profile,
                                      const FootSchedulerParams& gaits);
/// Parameters of a LeggedLocomotion with the standard profile and gaits. Throws ParameterError.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot);

/// Parameters of the observers for this model of the robot.
DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot, const LocomotionProfile& profile);

}  // namespace tenon
