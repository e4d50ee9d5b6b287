#pragma once

#include <tenon/plants/robots/internal/quadruped_urdf.h>

#include <filesystem>
#include <map>
#include <optional>
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
/// Legs are the four chains of three revolute joints that reach down. The positions of the hips determine
/// which legs are front, rear, left and right. All other joints are fixed at 0, or at their angle in `locked`
/// [rad].
///
/// The robot faces along `forward`. By default it faces along the axis of its abduction joints, in the
/// direction in which most names of the legs agree with their places.
///
/// A foot is the sphere among the collision shapes below the knee that is farthest from the knee. If there is
/// no sphere, it is the farthest frame, or the end of the shank's meshes.
///
/// In the nominal stance the feet are below the hips, at 0.7 of the leg's length. The knee bends in the
/// direction that needs the smaller angle, and backward if both angles are equal. If a leg would touch the
/// trunk that rolls by 0.5 rad over upright legs, all legs are turned outwards, by at most 0.2 rad.
///
/// Torque and speed limits are those of the URDF. With the weight W and the leg's length l, torques above 5 W
/// l and speeds below sqrt(g/l) are placeholders, which are replaced like missing limits. End stops have a
/// stiffness of 4 W l per rad. The ground yields by l/600 under a foot that carries W/4; its other parameters
/// are those of DogBot in units of W, l and sqrt(l/g).
///
/// Impossible inertias are corrected, with a note, or refused if `strict`.
///
/// Throws ParameterError with file, joints or links, and the remedy, if the URDF has no such legs, if their
/// joints do not turn about x, y and y, or if there is no foot or no stance; and the errors of ReadUrdf.
QuadrupedProposal ProposeQuadruped(const std::filesystem::path& urdf,
                                   const std::map<std::string, double, std::less<>>& locked = {},
                                   std::optional<internal::LinkAxis> forward = {}, bool strict = false);

}  // namespace tenon
