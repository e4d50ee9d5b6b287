#pragma once

#include <tenon/plants/model/attached_body.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/internal/urdf_file.h>
#include <tenon/plants/robots/robot_links.h>

namespace tenon::internal {

/// Limits of a joint in a robot's YAML file, which replace those in the URDF.
struct JointLimits {
  std::optional<double> torque;          ///< [N m]
  std::optional<double> speed;           ///< [rad/s]
  std::optional<Eigen::Vector2d> range;  ///< [rad]

  static FieldList Fields() {
    return {
        Field("torque_N_m", &JointLimits::torque).Positive().Because("remove it to use the URDF's value"),
        Field("speed_rad_per_s", &JointLimits::speed).Positive().Because("remove it to use the URDF's value"),
        {"range_rad", &JointLimits::range}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// An axis of the trunk link.
enum class LinkAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };
constexpr auto EnumNames(LinkAxis) {
  return std::array{Named{LinkAxis::kX, "x"},       Named{LinkAxis::kY, "y"},
                    Named{LinkAxis::kZ, "z"},       Named{LinkAxis::kMinusX, "-x"},
                    Named{LinkAxis::kMinusY, "-y"}, Named{LinkAxis::kMinusZ, "-z"}};
}
Eigen::Vector3d Along(LinkAxis axis);  ///< unit vector
/// The rotation from the robot's axes (x forward, y left, z up) to those of the trunk link, for two axes at
/// right angles.
Eigen::Matrix3d RotationOf(LinkAxis forward, LinkAxis up);

/// Properties in a robot's YAML file that determine how its URDF is read.
struct UrdfReading {
  bool strict = false;              ///< refuse inertias that no body has, instead of correcting them
  std::optional<double> mass;       ///< of the robot, shared by the bodies that have none in the URDF [kg]
  std::string trunk;                ///< link whose origin is that of the robot's frame; empty: the root
  LinkAxis forward = LinkAxis::kX;  ///< axis of that link along which the robot faces
  LinkAxis up = LinkAxis::kZ;       ///< axis of that link that points up
  std::array<std::string, kNumLegs> feet;  ///< names of the feet's links
  std::array<Eigen::Vector3d, kNumLegs> foot_centres{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
      Eigen::Vector3d::Zero()};        ///< centres of the foot spheres in the links' frames [m]
  LockedJoints locked;                 ///< joints that do not move
  std::vector<AttachedBody> actuated;  ///< names and drives of those among them that move outside the legs
  std::array<JointLimits, kJointsPerLeg> limits;  ///< replace the URDF's limits
};

/// Reads trunk and legs from a URDF file; the legs are found by the links of their feet. Links connected by
/// fixed or locked joints become one body. The links on actuated joints are part of the trunk of `robot`,
/// with these joints at rest, and are the bodies of `moving`. Returns warnings about corrected values with
/// file and line. Throws ParameterError that begins with the file's name.
std::vector<std::string> ReadUrdf(const std::filesystem::path& path, const UrdfReading& reading,
                                  QuadrupedDescription* robot, MovingParts* moving = nullptr);

/// Reads the frames of all links; `robot` is what ReadUrdf has read. Throws ParameterError.
RobotLinks ReadLinks(const std::filesystem::path& path, const UrdfReading& reading,
                     const QuadrupedDescription& robot);

}  // namespace tenon::internal
