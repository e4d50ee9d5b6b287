#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/plants/multibody/robot_multibody.h>

#include <fmt/format.h>

namespace tenon {

using internal::MassOf;

RobotMultibody::RobotMultibody(const RigidInertia& base, double gravity) : base_(base) {
  forces.setNumberOfThreads(1);
  SimTK::Force::Gravity(forces, matter, SimTK::Vec3(0, 0, -gravity));
  bodies_.push_back(SimTK::MobilizedBody::Free(matter.Ground(), SimTK::Transform(),
                                               SimTK::Body::Rigid(MassOf(base)), SimTK::Transform()));
}

void RobotMultibody::Replace(const RigidInertia& part) {
  replaced_ = replaced_ + part;
  if (replaced_.mass == 0) return;
  const RigidInertia rest = base_ + RigidInertia{-replaced_.mass, replaced_.com, -replaced_.inertia};
  if (!(rest.mass > 0))
    throw ParameterError(fmt::format(
        "the added bodies replace {} kg of a trunk or platform of {} kg; give bodies that are parts of it",
        replaced_.mass, base_.mass));
  CheckInertia(rest.inertia);
  base().setDefaultMassProperties(MassOf(rest));
}

void RobotMultibody::Name(const SimTK::MobilizedBody& added, const std::string& name) {
  if (name.empty() || name.find(',') != std::string::npos)
    throw ParameterError(fmt::format("an added joint has the name '{}'; give a name without commas", name));
  const int index = added.getMobilizedBodyIndex();
  for (const auto& [other, used] : names_)
    if (used == name && other != index)
      throw ParameterError(
          fmt::format("two added joints have the name '{}'; give each a name of its own", name));
  names_[index] = name;
}

void RobotMultibody::Draw(const SimTK::MobilizedBody& body, const Shape& shape) {
  drawn_.push_back({body.getMobilizedBodyIndex(), shape});
}

const RobotMultibody::Reference& RobotMultibody::AddReference(const SimTK::MobilizedBody& added) {
  return references_.emplace_back(Reference{added.getMobilizedBodyIndex()});
}

}  // namespace tenon
