#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

#include <Eigen/Core>

namespace tenon {

/// The ground around a robot as a plane. Level at z = 0 if nothing else is said.
struct GroundPlane {
  Vec<3> p_W = Vec<3>::Zero();    ///< a point of it [m]
  Vec<2> slope = Vec<2>::Zero();  ///< dz/dx and dz/dy

  double HeightAt(const Eigen::Vector2d& place) const;  ///< [m]
  Vec<3> Normal() const;                                ///< upwards, of length 1
  /// From the centre of a sphere on it to the point in contact [m].
  Vec<3> ContactArm(double radius) const { return -radius * Normal(); }
  static FieldList Fields() { return {{"p_W", &GroundPlane::p_W, "m"}, {"slope", &GroundPlane::slope}}; }
};

/// ZYX Euler angles (see euler.h) of a trunk parallel to ground of this slope whose x axis, seen from above,
/// points to `yaw` [rad]: with s = Rz(-yaw) slope, pitch = -atan(s_x), sin(roll) = s_y / sqrt(1 + |s|^2).
Eigen::Vector3d EulerOnSlope(const Eigen::Vector2d& slope, double yaw);
/// Their rates [rad/s].
Eigen::Vector3d EulerRateOnSlope(const Eigen::Vector2d& slope, const Eigen::Vector2d& slope_rate, double yaw,
                                 double yaw_rate);
/// What x and y of that trunk's frame are over ground: the first two rows and columns of its rotation.
Eigen::Matrix2d FootprintOnSlope(const Eigen::Vector2d& slope, double yaw);

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::GroundPlane);
