#pragma once

#include <tenon/plants/model/rigid_inertia.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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
  /// Throws ParameterError with the place that `what` names.
  [[noreturn]] void Fail(const std::string& what) const;
};

/// Reads a URDF. Limits on its size, nesting and numbers protect from files that are no robot's. Throws
/// ParameterError with file, line, and the link or joint.
UrdfFile ReadUrdfFile(const std::filesystem::path& path);

}  // namespace tenon::internal
