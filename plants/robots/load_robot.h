#pragma once

#include <tenon/plants/model/attached_body.h>
#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

struct YamlFile;

/// Reads a robot from a YAML file such as plants/robots/dogbot.yaml, which names a URDF file and adds
/// properties that URDF lacks. Throws ParameterError that begins with the file and the place in it for
///  - errors of the YAML reader, such as unknown and missing keys;
///  - an unreadable URDF, a missing foot, a leg that does not have three revolute joints, or other movable
///    joints;
///  - joints without limits of torque and speed;
///  - a body without mass or with a physically impossible inertia;
///  - feet whose position in the nominal stance contradicts their name (front: x > 0, left: y > 0).
QuadrupedDescription LoadQuadruped(const std::string& path);

/// Reads a robot from a YAML file, such as plants/robots/cdpr_4.yaml. Throws ParameterError.
CdprDescription LoadCdpr(const std::string& path);

/// Read the robot that a scenario names. They throw ParameterError, also for a robot of the other kind.
CdprDescription LoadCdpr(const YamlFile& what);
QuadrupedDescription LoadQuadruped(const YamlFile& what);
/// Returns the link to the real quadruped, "eth0" for `link: {unitree: eth0}`; empty without `link`.
std::string LoadPlace(const YamlFile& what);
/// Reads the links on the `actuated_joints` of a quadruped's file, such as those of an arm; none without this
/// key. LoadQuadruped returns the same robot with these joints at rest. In a program:
///
///     const MovingParts arm = LoadMovingParts({"my_robot.yaml"});
///     if (!arm.bodies.empty()) params.world.plant.extend = Attach(arm.bodies, arm.at_rest);
MovingParts LoadMovingParts(const YamlFile& what);
/// Returns warnings about the robot's URDF, each with file, line and the correction: impossible inertias of
/// links on fixed joints, and meshes that cannot be read.
std::vector<std::string> QuadrupedWarnings(const YamlFile& what);

}  // namespace tenon
