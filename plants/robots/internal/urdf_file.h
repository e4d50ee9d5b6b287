#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/robots/internal/urdf_check.h>

#include <Eigen/Geometry>
#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <filesystem>
#include <string>

namespace tenon::internal {

/// A URDF read by urdfdom, with the lines of its links and joints.
struct UrdfFile {
  std::string name;
  UrdfLines lines;
  urdf::ModelInterfaceSharedPtr model;

  /// Returns the file and the line of the first link or joint that a message names, as link 'this' or Joint
  /// [this].
  std::string PlaceOf(const std::string& what) const;
  /// Throws ParameterError with the place that `what` names.
  [[noreturn]] void Fail(const std::string& what) const;
};

/// Throws ParameterError if the file cannot be read or is no URDF.
UrdfFile ParseUrdf(const std::filesystem::path& path);

Eigen::Isometry3d ToEigen(const urdf::Pose& pose);
RigidInertia ToRigidInertia(const urdf::Inertial& in);
/// Returns the link whose frame moves freely: the root, or the child of its floating joint if the root is a
/// link without a body such as `world`.
urdf::LinkConstSharedPtr FloatingLink(const urdf::ModelInterface& model);
/// Returns whether a joint is revolute or continuous.
bool Turns(const urdf::Joint& joint);

}  // namespace tenon::internal
