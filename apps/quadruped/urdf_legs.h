#pragma once

#include <tenon/plants/robots/internal/quadruped_urdf.h>

namespace tenon {

/// The place of a leg as its name gives it: 1 for front or left, -1 for rear or right, 0 if the name does not
/// say.
struct LegPlace {
  int front = 0;
  int left = 0;
};

/// Reads the place of a leg from the name of one of its links or joints: "front_left_hip", "FL_calf",
/// "leftRearLegMotor", "lh_foot".
LegPlace PlaceInName(const std::string& name);

/// The revolute joints of a chain, starting at the root.
using UrdfChain = std::vector<const internal::UrdfJoint*>;
/// "a - b - c".
std::string NamesOf(const UrdfChain& chain);

/// Options of FindUrdfLegs.
struct UrdfLegsOptions {
  internal::LockedJoints locked;              ///< joints that are fixed
  std::optional<internal::LinkAxis> forward;  ///< axis of the trunk along which the robot faces; empty: found
  std::optional<internal::LinkAxis> up;       ///< axis of the trunk that points up; empty: found
};

/// The legs of a quadruped in its URDF, and the robot's frame B (x forward, y left, z up).
struct UrdfLegs {
  std::array<UrdfChain, kNumLegs> legs;  ///< in the order of kLegNames
  std::string trunk;                     ///< link whose origin is that of B; empty: the link that floats
  internal::LinkAxis forward = internal::LinkAxis::kX;
  internal::LinkAxis up = internal::LinkAxis::kZ;
  internal::LockedJoints locked;                   ///< joints outside the legs
  std::map<std::string, Eigen::Isometry3d> poses;  ///< poses of the links in B, with all joints at 0
  std::vector<std::string> notes;                  ///< remarks on choices
};

/// Finds the legs, the four chains of abduction, hip pitch and knee, and the axes of the robot, from
/// properties that do not depend on the pose at joint angles of 0: the axes of the abduction joints are along
/// the robot, the hips are beside each other across it. Its vertical points along z of the trunk, or
/// otherwise against the legs. It faces in the direction in which most names of the legs agree with their
/// places.
///
/// If the origin of the root link is far from the hips, the heaviest link of the trunk takes its place. A
/// joint that carries several legs, a spine, is locked. Throws ParameterError that says which kind of robot
/// it is, if it is no such quadruped.
UrdfLegs FindUrdfLegs(const internal::UrdfFile& file, const UrdfLegsOptions& options);

}  // namespace tenon
