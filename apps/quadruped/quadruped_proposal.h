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

/// A proposed YAML file of a robot, made from its URDF.
struct QuadrupedProposal {
  std::string yaml;  ///< text; it names the URDF by its file name, so that both must be in one directory
  std::vector<std::string> notes;  ///< remarks on values that were guessed, ignored or not found
};

/// Proposes the YAML file that a robot needs beside its URDF. Comments in the file explain each choice.
///
/// FindUrdfLegs finds the legs and the axes of the robot. All other joints are fixed at 0, or at their
/// position in the options.
///
/// A foot is the sphere among the collision shapes below the knee that is farthest from the knee. If there is
/// no sphere, it is the farthest frame, or the end of the shank's meshes.
///
/// In the nominal stance the feet are below the hips, at 0.7 of the leg's length, within the ranges of the
/// joints. The knee bends in the direction that is nearer to its angle of 0, and backward if both are alike.
/// If no stance is found, the robot is tried upside down. If a leg would touch the trunk that rolls by 0.5
/// rad over upright legs, all legs are turned outwards, by at most 0.2 rad.
///
/// Torque and speed limits are those of the URDF. With the weight W and the leg's length l, torques above 5 W
/// l and speeds below sqrt(g/l) are placeholders, which are replaced like missing limits. End stops have a
/// stiffness of 4 W l per rad. The ground yields by l/600 under a foot that carries W/4; its other parameters
/// are those of DogBot in units of W, l and sqrt(l/g).
///
/// Impossible inertias are corrected, with a note, or refused if `strict`. With a `mass` of the robot [kg],
/// bodies without mass get theirs by the volume of their shapes.
///
/// Throws ParameterError with file, joints or links, and the remedy, if the URDF has no such legs, or if
/// there is no foot or no stance; and the errors of ReadUrdf.
QuadrupedProposal ProposeQuadruped(const std::filesystem::path& urdf, const UrdfLegsOptions& options = {},
                                   bool strict = false, std::optional<double> mass = {});

}  // namespace tenon
