#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <string>
#include <vector>

namespace tenon::apps {

/// Draws the robot in its nominal stance as SVG: from the left, from the front and from above, to one scale,
/// with a scale bar of 0.1 m. Trunk, links and feet are plain shapes.
std::string DrawQuadruped(const QuadrupedDescription& robot);

/// The command line of tenon-robot.
struct RobotArguments {
  std::string urdf;                ///< URDF file of a quadruped
  std::string out;                 ///< output directory; empty: out/NAME
  std::vector<std::string> locks;  ///< fixed joints as JOINT=ANGLE [rad]
  std::string forward;             ///< axis along which the robot faces: x, y, z, -x, -y or -z; empty: found
  std::string up;                  ///< axis that points up, likewise
  bool strict = false;             ///< refuse impossible inertias instead of correcting them
};

/// Writes the YAML file and a picture of the robot in a URDF, then simulates it standing and trotting.
/// Returns the exit code of the last simulation. Throws ParameterError, and the errors of the outputs.
int ProposeRobot(const RobotArguments& arguments);

}  // namespace tenon::apps
