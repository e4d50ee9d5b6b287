#pragma once

#include <Eigen/Core>

namespace tenon {

/// The distance between the segments [p, p + u] and [q, q + v].
double SegmentDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& q,
                       const Eigen::Vector3d& v);

/// The distance of the segment [p, p + u] from the solid box about the origin, along the axes, of half the
/// edges `half`; 0 if they meet.
double SegmentBoxDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& half);

}  // namespace tenon
