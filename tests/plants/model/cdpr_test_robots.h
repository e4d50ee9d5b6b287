#pragma once

#include <tenon/plants/model/cdpr_description.h>

#include <numbers>

namespace tenon::test {

/// Four cables from the corners of a ceiling of 7 x 9 m to the top of a box of 15 kg, each on its anchor's
/// side; without arguments they are massless [kg/m] and end in points instead of pulleys [m].
inline CdprDescription FourCableRobot(double mass_per_length = 0, double pulley_radius = 0) {
  CdprDescription robot;
  robot.name = "four";
  robot.mass = 15;
  robot.inertia_B = Eigen::Vector3d(0.213, 0.133, 0.215).asDiagonal();
  for (const double x : {1, -1}) {
    for (const double y : {1, -1})
      robot.cables.push_back({{3.5 * x, 4.5 * y, 4}, {0.075 * x, 0.075 * y, 0.093}});
  }
  robot.cable = {.axial_stiffness = 27e3, .axial_damping = 135, .tension_min = 0, .tension_max = 800};
  robot.cable.mass_per_length = mass_per_length;
  robot.winch = {.mode = WinchMode::kTension, .time_constant = 0.02, .reel_damping = 90, .effective_mass = 8};
  robot.winch.pulley_radius = pulley_radius;
  return robot;
}

/// Gives each anchor of a robot a path of its own, from 0.1 to about 1 s.
inline CdprDescription WithMovingAnchors(CdprDescription robot) {
  for (std::size_t i = 0; i < robot.cables.size(); ++i) {
    const auto s = static_cast<double>(i + 1);
    robot.cables[i].anchor_path = {{0.1, 0.5, 0.8 + s / 50},
                                   {{0, 0, 0}, {0.1, 0.02 * s, -0.05}, {0.2 - 0.01 * s, 0.1, 0.03 * s}}};
  }
  return robot;
}
/// Gives all anchors of a robot the same path.
inline CdprDescription WithAnchorsOn(CdprDescription robot, const AnchorPath& path) {
  for (CableDescription& cable : robot.cables) cable.anchor_path = path;
  return robot;
}

/// Adds a spring that holds a part of the weight beside the CoM and one without rest length from the floor.
inline CdprDescription WithSprings(CdprDescription robot) {
  robot.springs = {{{0.5, -0.3, 4}, {0.1, 0.05, 0.1}, 60, 1.2}, {{-2, 1, 0}, {-0.05, 0.1, -0.1}, 8, 0}};
  return robot;
}

/// Three cables from 4 m high to attachments above the CoM, turned against the anchors.
inline CdprDescription ThreeCableRobot() {
  CdprDescription robot = FourCableRobot();
  robot.name = "three";
  robot.cables.clear();
  for (int i = 0; i < 3; ++i) {
    const double anchor = 2 * std::numbers::pi * i / 3, attachment = anchor + 0.3;
    robot.cables.push_back({{4 * std::cos(anchor), 4 * std::sin(anchor), 4},
                            {0.3 * std::cos(attachment), 0.3 * std::sin(attachment), 0.1}});
  }
  return robot;
}

/// Three or four cables from 4 m high to one point `above` the CoM [m].
inline CdprDescription OnePointRobot(int cables, double above) {
  CdprDescription robot = FourCableRobot();
  robot.name = "point";
  robot.cables.resize(static_cast<std::size_t>(cables));
  for (CableDescription& cable : robot.cables) cable.attachment_B = {0, 0, above};
  return robot;
}

/// Four cables that draw a bar over a level table, 1 m high.
inline CdprDescription TableRobot() {
  CdprDescription robot = FourCableRobot();
  robot.name = "table";
  robot.on_table = true;
  robot.cable.tension_min = 30;
  for (CableDescription& cable : robot.cables) {
    cable.anchor_W = {cable.anchor_W.x() / 2, cable.anchor_W.y() / 2, 1};
    cable.attachment_B = {2 * cable.attachment_B.x(), 0, 0};
  }
  return robot;
}

/// A planar robot in y = 0 with two cables from above or, with four, two from below as well.
inline CdprDescription PlanarRobot(int cables) {
  CdprDescription robot = FourCableRobot();
  robot.name = "planar";
  robot.cables.clear();
  for (const double z : {1, -1})
    for (const double x : {1, -1}) robot.cables.push_back({{3 * x, 0, 2 + 2 * z}, {0.25 * x, 0, 0.15 * z}});
  robot.cables.resize(static_cast<std::size_t>(cables));
  return robot;
}

/// FourCableRobot with a fifth cable, from the middle of the front wall.
inline CdprDescription FiveCableRobot() {
  CdprDescription robot = FourCableRobot();
  robot.name = "five";
  robot.cables.push_back({{3.5, 0, 4.5}, {0.1, 0, 0.05}});
  return robot;
}

/// Three anchors and three attachments, turned by 60 deg against each other; each anchor holds the two
/// nearest attachments.
inline CdprDescription SixCableRobot() {
  CdprDescription robot = FourCableRobot();
  robot.name = "six";
  robot.cables.clear();
  for (int i = 0; i < 6; ++i) {
    const double anchor = (i / 2) * 2 * std::numbers::pi / 3;
    const double attachment = anchor + (i % 2 == 0 ? 1 : -1) * std::numbers::pi / 3;
    robot.cables.push_back({{4 * std::cos(anchor), 4 * std::sin(anchor), 4},
                            {0.4 * std::cos(attachment), 0.4 * std::sin(attachment), 0.1}});
  }
  return robot;
}

/// One cable to each corner of a room of 7 x 9 x 4 m, crossed: the upper ones to the bottom of the platform.
inline CdprDescription EightCableRobot() {
  CdprDescription robot = FourCableRobot();
  robot.name = "eight";
  robot.cables.clear();
  for (const double z : {1, -1}) {
    for (const double x : {1, -1}) {
      for (const double y : {1, -1})
        robot.cables.push_back({{3.5 * x, 4.5 * y, 2 + 2 * z}, {0.3 * x, 0.2 * y, -0.15 * z}});
    }
  }
  return robot;
}

/// Hung from two rings of anchors, 4 m and 3.5 m high, by turns, an even number of cables in all. Cables of
/// one ring are led to attachments to the left of them, cables of the other ring to the right.
inline CdprDescription TwoRingRobot(int cables) {
  CdprDescription robot = FourCableRobot();
  robot.name = "rings";
  robot.cables.clear();
  for (int i = 0; i < cables; ++i) {
    const double side = i % 2 == 0 ? 1 : -1;
    const double anchor = 2 * std::numbers::pi * i / cables,
                 attachment = anchor + side * std::numbers::pi / 6;
    robot.cables.push_back({{4 * std::cos(anchor), 4 * std::sin(anchor), 3.75 + 0.25 * side},
                            {0.4 * std::cos(attachment), 0.4 * std::sin(attachment), 0.1}});
  }
  return robot;
}

/// A robot with any number of cables, even from nine on: the first cables of the smallest robot that has
/// them.
inline CdprDescription RobotWithCables(int cables) {
  CdprDescription robot = cables <= 4   ? FourCableRobot()
                          : cables == 5 ? FiveCableRobot()
                          : cables == 6 ? SixCableRobot()
                          : cables <= 8 ? EightCableRobot()
                                        : TwoRingRobot(cables);
  robot.cables.resize(static_cast<std::size_t>(cables));
  return robot;
}

}  // namespace tenon::test
