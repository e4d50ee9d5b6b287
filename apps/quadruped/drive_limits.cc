#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/customisation.h>
#include <tenon/apps/quadruped/drive_limits.h>

#include <fmt/core.h>

#include <string>

namespace tenon::apps {

std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant) {
  std::vector<SignalLimits> limits;
  if (FindCurrent(plant.joint_torque) == nullptr || !KnowsLimits<QuadrupedPlantParams>(plant)) return limits;
  const std::vector<Element> joints = Current(plant.joint_torque).elements();
  for (int i = 0; i < kNumJoints; ++i) {
    const JointDescription& joint = ParamsOf(plant).robot.joint(i);
    const std::string& name = joints[static_cast<std::size_t>(i)].name;
    limits.push_back({fmt::format("{}.{}", SignalName(plant.joint_torque), name),
                      {.low = -joint.torque_limit, .high = joint.torque_limit}});
    limits.push_back({fmt::format("{}.{}", SignalName(plant.state, &LeggedState::qd), name),
                      {.low = -joint.speed_limit, .high = joint.speed_limit}});
  }
  return limits;
}

}  // namespace tenon::apps
