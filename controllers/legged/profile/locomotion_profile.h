#pragma once

#include <array>
#include <string>

#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/observers/nonlinear_disturbance_observer.h>
#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/controllers/legged/planning/trunk_planner.h>
#include <tenon/controllers/legged/whole_body/whole_body_controller.h>

namespace tenon {

struct YamlText;

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

/// How a walking controller is tuned; read from a file such as controllers/profiles/standard.yaml.
struct LocomotionProfile {
  WholeBodyGains whole_body;
  double sway_limit = 80;  ///< of the TrunkPlanner [rad/s^2]
  GroundBelief ground;
  double qp_rate_hz = 1000;
  ObserverProfile observer;

  static FieldList Fields() {
    return {Required("whole_body", &LocomotionProfile::whole_body),
            Required("sway_limit_rad_per_s2", &LocomotionProfile::sway_limit),
            Required("ground", &LocomotionProfile::ground),
            Required("qp_rate_hz", &LocomotionProfile::qp_rate_hz),
            Required("observer", &LocomotionProfile::observer)};
  }
};

/// The profile that ships with Tenon under a name, or a file. Throws ParameterError.
LocomotionProfile LoadLocomotionProfile(const std::string& name);
/// The same, or one with what differs, see LoadResource.
LocomotionProfile LoadLocomotionProfile(const YamlText& what);

/// Parameters of a LeggedLocomotion for a robot as its controller knows it, with gaits that ship under a name
/// or stand in a file. Throws ParameterError.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot,
                                      const LocomotionProfile& profile = LoadLocomotionProfile("standard"),
                                      const std::string& gaits = "standard");

/// Parameters of the observers beside it, for the same robot.
DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot,
                                       const LocomotionProfile& profile = LoadLocomotionProfile("standard"));

}  // namespace tenon
