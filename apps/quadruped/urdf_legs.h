#pragma once

#include <tenon/plants/robots/internal/quadruped_urdf.h>
#include <tenon/plants/robots/internal/urdf_file.h>

#include <Eigen/Geometry>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// The revolute joints of a chain, starting at the root.
using UrdfChain = std::vector<const internal::UrdfJoint*>;
/// "a - b - c".
std::string NamesOf(const UrdfChain& chain);

/// Least cosine of the angle between a joint's axis and the axis of the robot about which it turns.
inline constexpr double kAlong = 0.8;

/// Options of FindUrdfLegs.
struct UrdfLegsOptions {
  std::map<std::string, double> locked;       ///< joints that are fixed, and their angles [rad]
  std::optional<internal::LinkAxis> forward;  ///< axis of the trunk along which the robot faces; empty: found
};

/// The legs of a quadruped in its URDF, and the robot's frame B (x forward, y left, z up).
struct UrdfLegs {
  std::array<UrdfChain, kNumLegs> legs;  ///< in the order of kLegNames
  std::string trunk;                     ///< link whose origin is that of B; empty: the link that floats
  internal::LinkAxis forward = internal::LinkAxis::kX;
  internal::LinkAxis up = internal::LinkAxis::kZ;
  std::map<std::string, double> locked;            ///< joints outside the legs, and their angles [rad]
  std::map<std::string, Eigen::Isometry3d> poses;  ///< poses of the links in B, with all joints at 0
  std::vector<std::string> notes;                  ///< remarks on choices
};

/// Finds the four chains of three revolute joints that reach down, and the axes of the robot: up against the
/// legs, forward along the axes of the abduction joints in the direction in which most names of the legs
/// agree with their places. If the origin of the root link is far from the hips, the heaviest link of the
/// trunk takes its place. Throws ParameterError that says which kind of robot it is, if it is no such
/// quadruped.
UrdfLegs FindUrdfLegs(const internal::UrdfFile& file, const UrdfLegsOptions& options);

}  // namespace tenon
