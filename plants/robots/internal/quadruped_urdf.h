#pragma once

#include <tenon/plants/model/attached_body.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/robot_links.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <filesystem>
#include <functional>

namespace tenon::internal {

/// A shape that a link shows or collides with.
struct UrdfShape {
  enum class Kind { kMesh, kSphere, kCylinder, kBox };
  Kind kind = Kind::kMesh;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the link
  std::string mesh;                                        ///< its file, as in the URDF
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();         ///< of a mesh
  Eigen::Vector3d edges = Eigen::Vector3d::Zero();         ///< of a box [m]
  double radius = 0;                                       ///< of a sphere or cylinder [m]
  double length = 0;                                       ///< of a cylinder [m]
  std::optional<std::array<float, 3>> colour;              ///< red, green, blue; none if it is a texture
};

struct UrdfLink;

struct UrdfJoint {
  enum class Type { kFixed, kRevolute, kContinuous, kPrismatic, kFloating, kPlanar };
  struct Limits {
    double lower = 0, upper = 0;  ///< [rad], [m] if it slides
    double effort = 0;            ///< [N m]; 0 if the URDF has none
    double velocity = 0;          ///< [rad/s]; 0 if the URDF has none
  };
  struct Mimic {
    std::string joint;
    double multiplier = 1, offset = 0;
  };
  std::string name;
  std::size_t line;
  Type type;
  std::string parent, child;                               ///< names of links
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the parent link
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  std::optional<Limits> limits;  ///< revolute and prismatic joints have some
  std::optional<Mimic> mimic;
  double damping = 0, friction = 0;  ///< [N m s/rad], [N m]

  /// Whether it is revolute or continuous.
  bool turns() const { return type == Type::kRevolute || type == Type::kContinuous; }
  bool slides() const { return type == Type::kPrismatic; }
  /// The position within its range that is nearest to 0 [rad or m].
  double Neutral() const;
  /// The motion of its child from position 0 to another one [rad or m].
  Eigen::Isometry3d Moved(double position) const;
};

/// Positions of joints that are fixed, by name [rad or m].
using LockedJoints = std::map<std::string, double, std::less<>>;
/// Returns the position of a joint that is locked itself or mimics a locked joint.
std::optional<double> LockedAt(const UrdfJoint& joint, const LockedJoints& locked);

struct UrdfLink {
  std::string name;
  std::size_t line;
  std::optional<RigidInertia> inertia;  ///< in the link
  std::vector<UrdfShape> visuals, collisions;
  const UrdfJoint* parent_joint = nullptr;  ///< null for the root
  const UrdfLink* parent = nullptr;
  std::vector<const UrdfJoint*> joints;  ///< those to its children, by name
};

/// A URDF. Its links form a tree.
struct UrdfFile {
  std::string name;
  std::string robot;  ///< its name
  std::map<std::string, UrdfLink, std::less<>> links;
  std::map<std::string, UrdfJoint, std::less<>> joints;
  const UrdfLink* root = nullptr;
  std::vector<std::string> unread;  ///< messages on elements that are not read, with their lines

  const UrdfLink* FindLink(std::string_view link) const;     ///< null if there is none
  const UrdfJoint* FindJoint(std::string_view joint) const;  ///< null if there is none
  const UrdfLink& ChildOf(const UrdfJoint& joint) const { return links.at(joint.child); }
  /// Returns the link whose frame moves freely: the root, or the child of its floating joint if the root is a
  /// link without a body such as `world`.
  const UrdfLink& FloatingLink() const;

  /// Returns the file and the line of the first link or joint that a message names, as link 'this'.
  std::string PlaceOf(const std::string& what) const;
  /// Throws ParameterError with the place that the message names.
  template <class... Args>
  [[noreturn]] void Fail(fmt::format_string<Args...> format, Args&&... args) const {
    const std::string what = fmt::format(format, std::forward<Args>(args)...);
    throw ParameterError(PlaceOf(what) + ": " + what);
  }
};

/// Reads a URDF. Limits on its size, nesting and numbers protect from files that are no robot's. Throws
/// ParameterError with file, line, and the link or joint.
UrdfFile ReadUrdfFile(const std::filesystem::path& path);

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
