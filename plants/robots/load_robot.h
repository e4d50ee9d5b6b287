#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/quadruped_description.h>

#include <string>
#include <vector>

namespace tenon {

struct YamlFile;

/// Reads a robot: a YAML file such as plants/robots/dogbot.yaml, which names a URDF file beside it and tells
/// what URDF cannot. Throws ParameterError, beginning with the file and the place in it, for
///  - what the YAML reader refuses, among others unknown and missing keys;
///  - a URDF that cannot be read; a foot that it does not have; a foot with other than three revolute joints
///    above it; further joints that move; a joint without limits of torque and speed;
///  - a body without mass, or with an inertia that no rigid body has;
///  - feet that are not where their names say (front: x > 0, left: y > 0) in the nominal stance.
QuadrupedDescription LoadQuadruped(const std::string& path);

/// Reads a robot from a YAML file, such as plants/robots/cdpr_4.yaml. Throws ParameterError.
CdprDescription LoadCdpr(const std::string& path);

/// The robot that a scenario names. Throw ParameterError, among others for one of the other kind.
CdprDescription LoadCdpr(const YamlFile& what);
QuadrupedDescription LoadQuadruped(const YamlFile& what);
/// What of its URDF was not taken as it stands, each with file, line and what was taken instead: inertias
/// that no body has, of frames on fixed joints, and meshes that cannot be read.
std::vector<std::string> QuadrupedWarnings(const YamlFile& what);

}  // namespace tenon
