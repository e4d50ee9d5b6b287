#include <tenon/apps/quadruped/held_mass.h>
#include <tenon/controllers/legged/whole_body/joint_pd.h>

#include <fmt/core.h>

namespace tenon::apps {

HeldMass HeldByTwoLegs(const QuadrupedDescription& robot) {
  const Vec<kNumJoints> torque = 2 * StandingTorque(robot, kGravity);  // a foot carries half of the weight
  constexpr double kAny = std::numeric_limits<double>::infinity();
  HeldMass held{.mass = kAny, .load = kAny};
  for (int j = 0; j < kNumJoints; ++j) {
    const double mass = robot.mass() * robot.joint(j).torque_limit / std::abs(torque[j]);
    if (mass < held.mass) held = {mass, std::max(0.0, mass - robot.mass()), j, std::abs(torque[j])};
  }
  return held;
}

std::string CannotHold(const QuadrupedDescription& robot, const HeldMass& held) {
  const JointDescription& joint = robot.joint(held.joint);
  return fmt::format(
      "in a trot, two legs hold the robot, for which joint '{}' needs {:.3g} N m in the nominal stance, but "
      "its limit is {:.3g} N m: the robot may fall",
      joint.name, held.torque, joint.torque_limit);
}

}  // namespace tenon::apps
