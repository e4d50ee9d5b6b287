#pragma once

#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

/// Command to the drives of all joints, each of which closes its own loop, see JointDrives:
///
///     torque + kp (q - q_now) + kd (qd - qd_now).
struct JointCommand {
  Vec<12> q = Vec<12>::Zero();       ///< [rad]
  Vec<12> qd = Vec<12>::Zero();      ///< [rad/s]
  Vec<12> torque = Vec<12>::Zero();  ///< [N m]
  Vec<12> kp = Vec<12>::Zero();      ///< [N m/rad]
  Vec<12> kd = Vec<12>::Zero();      ///< [N m s/rad]

  Vec<12> TorqueAt(const JointMotion& now) const {
    return torque + kp.cwiseProduct(q - now.q) + kd.cwiseProduct(qd - now.qd);
  }
  static FieldList Fields() {
    return {{"q", &JointCommand::q, "rad", kJointElements},
            {"qd", &JointCommand::qd, "rad/s", kJointElements},
            {"torque", &JointCommand::torque, "N m", kJointElements},
            {"kp", &JointCommand::kp, "N m/rad", kJointElements},
            {"kd", &JointCommand::kd, "N m s/rad", kJointElements}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::JointCommand);
