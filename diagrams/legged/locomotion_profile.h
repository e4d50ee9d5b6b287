#pragma once

#include <tenon/controllers/legged/comparison/nonlinear_disturbance_observer.h>
#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/controllers/legged/planning/trunk_planner.h>
#include <tenon/controllers/legged/whole_body/whole_body_controller.h>
#include <tenon/plants/model/robot_scale.h>

#include <array>
#include <string>

namespace tenon {

struct YamlFile;

/// Which estimates a controller is given.
enum class ObserverKind {
  kNone,        ///< zeros
  kLegs,        ///< of the legs
  kCom,         ///< of the net wrench
  kHybrid,      ///< both
  kFocchi,      ///< of the net wrench by CentroidalMomentumObserver
  kNdoM,        ///< of the legs by NonlinearDisturbanceObserver, reading kM
  kNdoInverse,  ///< the same, reading kInverse
};
constexpr auto EnumNames(ObserverKind) {
  return std::array{Named{ObserverKind::kNone, "none"},
                    Named{ObserverKind::kLegs, "legs"},
                    Named{ObserverKind::kCom, "com"},
                    Named{ObserverKind::kHybrid, "hybrid"},
                    Named{ObserverKind::kFocchi, "focchi"},
                    Named{ObserverKind::kNdoM, "ndo_m"},
                    Named{ObserverKind::kNdoInverse, "ndo_inverse"}};
}

/// The kind decides which of the blocks there are; `focchi` takes its gains from CentroidalMomentumObserver,
/// and the reading of `ndo` is the kind's.
struct DisturbanceObserverParams {
  ObserverKind kind = ObserverKind::kHybrid;
  LegMomentumObserverParams legs;
  ComObserverParams com;
  NonlinearDisturbanceObserverParams ndo;
};

/// Of the six blocks of a LeggedLocomotion.
struct LeggedLocomotionParams {
  FootSchedulerParams scheduler;
  GroundEstimatorParams ground;
  ComPlannerParams com_planner;
  SwingPlannerParams swing_planner;
  TrunkPlannerParams trunk_planner;
  WholeBodyParams whole_body;
};

/// How the observers are tuned, and which are used.
struct ObserverProfile {
  ObserverKind kind = ObserverKind::kHybrid;
  LegObserverGains legs;
  ComObserverGains com;
  double ndo_gain = 10;  ///< X of the nonlinear disturbance observer, see there

  static FieldList Fields() {
    return {Required("kind", &ObserverProfile::kind), Required("legs", &ObserverProfile::legs),
            Required("com", &ObserverProfile::com), Required("ndo_gain", &ObserverProfile::ndo_gain)};
  }
};

/// How the walking controller of one robot is tuned. Files such as diagrams/profiles/standard.yaml give it
/// for robots of all sizes, in the units of RobotScale: m, l, g, t = sqrt(l / g) in a key stand for them, say
/// `com_stiffness_mg_per_l`. In the optimisation's weights force counts in m g, torque in m g l and
/// acceleration in g. Angles, rates and accelerations over errors have no size and are as they are.
struct LocomotionProfile {
  WholeBodyGains whole_body;
  double sway_limit = 80;  ///< of the TrunkPlanner [rad/s^2]
  GroundBelief ground;
  double qp_rate_hz = 1000;
  ObserverProfile observer;
};

/// The profile that ships with Tenon under a name, or a file, for a robot. Throws ParameterError.
LocomotionProfile LoadLocomotionProfile(const std::string& name, const RobotScale& scale);
/// The same, or one with what differs, see LoadResource.
LocomotionProfile LoadLocomotionProfile(const YamlFile& what, const RobotScale& scale);

/// Parameters of a LeggedLocomotion for a robot as its controller knows it, with gaits that ship under a name
/// or stand in a file. The profile may be that of the robot as it is. Throws ParameterError.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot, const LocomotionProfile& profile,
                                      const std::string& gaits = "standard");
/// With the standard profile for this robot.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot);
/// The table of gaits that a scenario names, see LoadResource, for a robot.
FootSchedulerParams LoadGaits(const YamlFile& what, const RobotScale& scale);

/// Parameters of the observers beside it, for the same robot.
DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot, const LocomotionProfile& profile);
DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot);

}  // namespace tenon
