#pragma once

#include <tenon/apps/quadruped/urdf_legs.h>

namespace tenon {

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
