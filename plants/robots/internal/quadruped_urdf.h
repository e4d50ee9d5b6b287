#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <Eigen/Core>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon::internal {

/// What a robot's YAML says of joints instead of the URDF.
struct JointLimits {
  std::optional<double> torque;          ///< [N m]
  std::optional<double> speed;           ///< [rad/s]
  std::optional<Eigen::Vector2d> range;  ///< [rad]

  static FieldList Fields() {
    return {{"torque_N_m", &JointLimits::torque},
            {"speed_rad_per_s", &JointLimits::speed},
            {"range_rad", &JointLimits::range}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What a robot's YAML says of its URDF.
struct UrdfReading {
  std::array<std::string, kNumLegs> feet;  ///< links
  std::array<Eigen::Vector3d, kNumLegs> foot_centres{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
      Eigen::Vector3d::Zero()};                       ///< of the spheres, in the links' frames [m]
  std::map<std::string, double, std::less<>> locked;  ///< joints that do not turn, at which angle [rad]
  std::array<JointLimits, kJointsPerLeg> limits;      ///< instead of the URDF's
};

/// Reads trunk and legs from a URDF file, the legs from the names of their feet's links. Links that fixed or
/// locked joints connect become one body. Returns what it did not take as it stands, each with file and line.
/// Throws ParameterError, beginning with the file's name.
std::vector<std::string> ReadUrdf(const std::filesystem::path& path, const UrdfReading& reading,
                                  QuadrupedDescription* robot);

}  // namespace tenon::internal
