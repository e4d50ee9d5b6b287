#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tenon {

/// The YAML file of a robot as it follows from its URDF.
struct QuadrupedProposal {
  std::string yaml;                ///< names the URDF by its file name: it belongs beside it
  std::vector<std::string> notes;  ///< what was guessed, left out or not found
};

/// Proposes what a robot's YAML file has to say beside its URDF; every choice is explained there.
///
///  - Legs are the four chains of three joints that turn, those that reach lowest if there are more; their
///    hips tell front from rear and left from right. Other joints are locked, at 0 or where `locked` says
///    [rad].
///  - A foot is the sphere among the collision shapes below the knee that is farthest from it, else the
///    farthest frame.
///  - In the nominal stance feet are below the hips, at 0.7 of the leg's length; the knees point where they
///    are less bent, backward if that is all the same, within the joints' ranges.
///  - Torque and speed limits are the URDF's where it has any. With the weight W and the leg's length l, end
///    stops have 4 W l per rad; the ground yields l/600 to a foot that carries W/4, and has the other
///    numbers of DogBot's in units of W, l and sqrt(l/g).
///
/// Throws ParameterError with the file, the joints or links meant and the remedy if there are no such legs,
/// if they do not turn about x, y and y, if there is no foot or no stance, and what ReadUrdf throws.
QuadrupedProposal ProposeQuadruped(const std::filesystem::path& urdf,
                                   const std::map<std::string, double, std::less<>>& locked = {});

}  // namespace tenon
