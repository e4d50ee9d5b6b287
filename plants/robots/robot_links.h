#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace tenon {

struct YamlFile;

/// The frames of a quadruped's links in its URDF, by which ROS draws it.
struct RobotLinks {
  /// A frame in its parent's. It turns by the angle of a joint of a leg, or is at rest.
  struct Link {
    std::string parent, name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< at the joint angle 0
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();         ///< unit vector, in this frame
    int joint = -1;                                          ///< index of the joint; -1: at rest
  };
  std::string urdf;  ///< text of the file
  std::string base =
      "base_link";          ///< name of the robot's frame B; "base" if another frame is named base_link
  std::vector<Link> links;  ///< each one follows its parent; the root link has B as its parent
};

/// Reads the frames of the robot that a scenario names. Links on locked and actuated joints are at rest.
/// Throws ParameterError as LoadQuadruped does.
RobotLinks LoadRobotLinks(const YamlFile& what);

}  // namespace tenon
