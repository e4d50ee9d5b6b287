#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon {

using internal::MassOf;
using internal::NearestName;
using internal::ToSimbody;

QuadrupedMultibody::QuadrupedMultibody(const QuadrupedDescription& robot, double gravity)
    : RobotMultibody(robot.trunk, gravity) {
  bodies_.reserve(1 + kNumJoints);  // `base` and `link` return references
  for (std::size_t j = 0; j < kNumJoints; ++j) {
    const std::size_t leg = j / kJointsPerLeg, i = j % kJointsPerLeg;
    const JointDescription& joint = robot.legs[leg].joints[i];
    const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(joint.axis)), SimTK::ZAxis);  // a Pin turns about z
    bodies_.push_back(SimTK::MobilizedBody::Pin(
        bodies_[i == 0 ? 0 : j], SimTK::Transform(R, ToSimbody(joint.p_PJ)),
        SimTK::Body::Rigid(MassOf(robot.legs[leg].bodies[i])), SimTK::Transform(R)));
    joints_[j] = joint.name;
  }
}

SimTK::MobilizedBody& QuadrupedMultibody::link(const std::string& joint) {
  for (std::size_t j = 0; j < kNumJoints; ++j)
    if (joints_[j] == joint) return bodies_[1 + j];
  const std::string nearest = NearestName(joint, {joints_.begin(), joints_.end()});
  throw ParameterError(
      fmt::format("the robot has no joint '{}'{}; give the name of one of the twelve joints of its legs",
                  joint, nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}

}  // namespace tenon
