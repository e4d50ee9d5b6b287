#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tenon {

/// A proposed YAML file of a robot, made from its URDF.
struct QuadrupedProposal {
  std::string yaml;  ///< text; it names the URDF by its file name, so that both must be in one directory
  std::vector<std::string> notes;  ///< remarks on values that were guessed, ignored or not found
};

/// Proposes the YAML file that a robot needs beside its URDF. Comments in the file explain each choice.
///
/// Legs are the four chains of three revolute joints; if there are more chains, the four that reach lowest.
/// The positions of the hips determine which legs are front, rear, left and right. All other joints are fixed
/// at 0, or at their angle in `locked` [rad].
///
/// A foot is the sphere among the collision shapes below the knee that is farthest from the knee, or the
/// farthest frame if there is no sphere.
///
/// In the nominal stance the feet are below the hips, at 0.7 of the leg's length. The knee bends in the
/// direction that needs the smaller angle, and backward if both angles are equal.
///
/// Torque and speed limits are those of the URDF, if it has any. With the weight W and the leg's length l,
/// end stops have a stiffness of 4 W l per rad. The ground yields by l/600 under a foot that carries W/4; its
/// other parameters are those of DogBot in units of W, l and sqrt(l/g).
///
/// Throws ParameterError with file, joints or links, and the remedy, if the URDF has no such legs, if their
/// joints do not turn about x, y and y, or if there is no foot or no stance; and the errors of ReadUrdf.
QuadrupedProposal ProposeQuadruped(const std::filesystem::path& urdf,
                                   const std::map<std::string, double, std::less<>>& locked = {});

}  // namespace tenon
