#pragma once

#include <Eigen/Core>

namespace tenon {

/// The distance between the segments [p, p + u] and [q, q + v].
double SegmentDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& q,
                       const Eigen::Vector3d& v);

/// The distance between the segment [p, p + u] and the solid axis-aligned box about the origin with half
/// edges `half`; 0 if they intersect.
double SegmentBoxDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& half);

}  // namespace tenon
