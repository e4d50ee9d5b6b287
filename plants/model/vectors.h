#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tenon {

/// The shortest rotation that turns the direction of `from` into that of `to`; for opposite directions, one
/// of the half turns.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The distance between the segments [p, p + u] and [q, q + v]. `at` receives (s, t) of the nearest points
/// p + s u and q + t v.
double SegmentDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& q,
                       const Eigen::Vector3d& v, Eigen::Vector2d* at = nullptr);

/// The distance between the segment [p, p + u] and the solid axis-aligned box about the origin with half
/// edges `half`; 0 if they intersect. `at` receives s of the nearest point p + s u.
double SegmentBoxDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& half,
                          double* at = nullptr);

/// [a]x, with [a]x b = a x b. Always inlined, since some callers are compiled for wider vector instructions.
[[gnu::always_inline]] inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d cross;
  cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return cross;
}

/// The vector with its length limited to `longest`.
template <int n>
Eigen::Matrix<double, n, 1> Shortened(const Eigen::Matrix<double, n, 1>& v, double longest) {
  const double length = v.norm();
  if (length <= longest) return v;
  return v * (longest / length);
}

}  // namespace tenon
