#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Plane that approximates the ground around a robot; level at z = 0 by default.
struct GroundPlane {
  Vec<3> p_W = Vec<3>::Zero();    ///< a point of the plane [m]
  Vec<2> slope = Vec<2>::Zero();  ///< dz/dx and dz/dy

  double HeightAt(const Eigen::Vector2d& place) const;  ///< [m]
  Vec<3> Normal() const;                                ///< upward unit normal
  /// Vector from the centre of a sphere on the plane to the contact point [m].
  Vec<3> ContactArm(double radius) const { return -radius * Normal(); }
  static FieldList Fields() { return {{"p_W", &GroundPlane::p_W, "m"}, {"slope", &GroundPlane::slope}}; }
};

/// ZYX Euler angles (see euler.h) of a trunk parallel to ground of this slope whose x axis, seen from above,
/// has the heading `yaw` [rad]: with s = Rz(-yaw) slope, pitch = -atan(s_x), sin(roll) = s_y / sqrt(1 +
/// |s|^2).
Eigen::Vector3d EulerOnSlope(const Eigen::Vector2d& slope, double yaw);
/// Rates of EulerOnSlope [rad/s].
Eigen::Vector3d EulerRateOnSlope(const Eigen::Vector2d& slope, const Eigen::Vector2d& slope_rate, double yaw,
                                 double yaw_rate);
/// Horizontal components of that trunk's x and y axes: the top left 2 x 2 block of its rotation matrix.
Eigen::Matrix2d FootprintOnSlope(const Eigen::Vector2d& slope, double yaw);

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::GroundPlane);
