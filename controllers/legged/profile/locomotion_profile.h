#pragma once

#include <string>

#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/diagrams/legged/legged_locomotion.h>

namespace tenon {

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
  double qp_rate_hz = 1000;
  ObserverProfile observer;

  static FieldList Fields() {
    return {Required("whole_body", &LocomotionProfile::whole_body),
            Required("sway_limit_rad_per_s2", &LocomotionProfile::sway_limit),
            Required("qp_rate_hz", &LocomotionProfile::qp_rate_hz),
            Required("observer", &LocomotionProfile::observer)};
  }
};

/// The profile that ships with Tenon under a name, or a file. Throws ParameterError.
LocomotionProfile LoadLocomotionProfile(const std::string& name);

/// Parameters of a LeggedLocomotion for a robot as its controller knows it, with gaits that ship under a name
/// or stand in a file. Throws ParameterError.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot,
                                      const LocomotionProfile& profile = LoadLocomotionProfile("standard"),
                                      const std::string& gaits = "standard");

/// Parameters of the observers beside it, for the same robot.
DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot,
                                       const LocomotionProfile& profile = LoadLocomotionProfile("standard"));

}  // namespace tenon
