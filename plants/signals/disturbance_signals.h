#pragma once

#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

/// Estimated net wrench of all external forces except gravity and ground forces.
struct WrenchEstimate {
  Vec<3> force_W = Vec<3>::Zero();   ///< [N]
  Vec<3> torque_W = Vec<3>::Zero();  ///< about the CoM [N m]

  static FieldList Fields() {
    return {{"force_W", &WrenchEstimate::force_W, "N"}, {"torque_W", &WrenchEstimate::torque_W, "N m"}};
  }
};

/// Estimated effect of external forces on the legs: joint torques, and equivalent forces on the feet.
struct LegForceEstimate {
  Vec<12> joint_torque = Vec<12>::Zero();  ///< [N m]
  FootForces foot_force;                   ///< in W [N]

  static FieldList Fields() {
    return {{"joint_torque", &LegForceEstimate::joint_torque, "N m", kJointElements},
            {"foot_force", &LegForceEstimate::foot_force}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::WrenchEstimate);
TENON_DECLARE_SIGNAL(tenon::LegForceEstimate);
