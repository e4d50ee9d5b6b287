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

/// Limits of a joint in a robot's YAML file, which replace those in the URDF.
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

/// Properties in a robot's YAML file that determine how its URDF is read.
struct UrdfReading {
  std::array<std::string, kNumLegs> feet;  ///< names of the feet's links
  std::array<Eigen::Vector3d, kNumLegs> foot_centres{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
      Eigen::Vector3d::Zero()};  ///< centres of the foot spheres in the links' frames [m]
  std::map<std::string, double, std::less<>> locked;  ///< angles of locked joints by name [rad]
  std::array<JointLimits, kJointsPerLeg> limits;      ///< replace the URDF's limits
};

/// Reads trunk and legs from a URDF file; the legs are found by the links of their feet. Links connected by
/// fixed or locked joints become one body. Returns warnings about corrected values with file and line. Throws
/// ParameterError that begins with the file's name.
std::vector<std::string> ReadUrdf(const std::filesystem::path& path, const UrdfReading& reading,
                                  QuadrupedDescription* robot);

}  // namespace tenon::internal
