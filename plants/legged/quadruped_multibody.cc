#include <tenon/plants/legged/internal/simbody_conversions.h>
#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/nearest_name.h>

#include <fmt/format.h>

namespace tenon {

using internal::MassOf;
using internal::NearestName;
using internal::ToSimbody;

QuadrupedMultibody::QuadrupedMultibody(const QuadrupedDescription& robot, double gravity)
    : trunk_(robot.trunk) {
  forces.setNumberOfThreads(1);
  SimTK::Force::Gravity(forces, matter, SimTK::Vec3(0, 0, -gravity));
  bodies_[0] = SimTK::MobilizedBody::Free(matter.Ground(), SimTK::Transform(),
                                          SimTK::Body::Rigid(MassOf(robot.trunk)), SimTK::Transform());
  for (std::size_t j = 0; j < kNumJoints; ++j) {
    const std::size_t leg = j / kJointsPerLeg, i = j % kJointsPerLeg;
    const JointDescription& joint = robot.legs[leg].joints[i];
    const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(joint.axis)), SimTK::ZAxis);  // a Pin turns about z
    bodies_[1 + j] =
        SimTK::MobilizedBody::Pin(bodies_[i == 0 ? 0 : j], SimTK::Transform(R, ToSimbody(joint.p_PJ)),
                                  SimTK::Body::Rigid(MassOf(robot.legs[leg].bodies[i])), SimTK::Transform(R));
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

void QuadrupedMultibody::Replace(const RigidInertia& part) {
  replaced_ = replaced_ + part;
  if (replaced_.mass == 0) return;
  const RigidInertia rest = trunk_ + RigidInertia{-replaced_.mass, replaced_.com, -replaced_.inertia};
  if (!(rest.mass > 0))
    throw ParameterError(
        fmt::format("the added bodies replace {} kg of a trunk of {} kg; give bodies that are parts of it",
                    replaced_.mass, trunk_.mass));
  CheckInertia(rest.inertia);
  trunk().setDefaultMassProperties(MassOf(rest));
}

void QuadrupedMultibody::Name(const SimTK::MobilizedBody& added, const std::string& name) {
  if (name.empty() || name.find(',') != std::string::npos)
    throw ParameterError(fmt::format("an added joint has the name '{}'; give a name without commas", name));
  const int index = added.getMobilizedBodyIndex();
  for (const auto& [other, used] : names_)
    if (used == name && other != index)
      throw ParameterError(
          fmt::format("two added joints have the name '{}'; give each a name of its own", name));
  names_[index] = name;
}

void QuadrupedMultibody::Draw(const SimTK::MobilizedBody& body, const Shape& shape) {
  drawn_.push_back({body.getMobilizedBodyIndex(), shape});
}

}  // namespace tenon
