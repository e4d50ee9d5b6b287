#pragma once

#include <tenon/plants/signals/joint_command.h>
#include <tenon/systems/framework/block/ports.h>

namespace tenon {

struct JointDrivesParams {
  Rate rate = Hz(1000);
};

/// The loops in the drives of a robot: torque + kp (q - q_now) + kd (qd - qd_now) with the drives' own
/// measurement of the joints. The plant limits the torques.
class JointDrives final : public LeafSystem<JointDrivesParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<JointCommand> command{this, {"command"}};
  InputPort<JointMotion> joints{this, {"joints"}};
  OutputPort<Vec<12>> torque{
      this,
      {"torque", "N m", kJointElements},
      Sampled{params.rate},
      Uses(command, joints),
      [](const JointCommand& given, const JointMotion& now) { return given.TorqueAt(now); }};
};

}  // namespace tenon
