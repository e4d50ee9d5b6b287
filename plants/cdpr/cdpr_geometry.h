#pragma once

#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// Height in W of the lowest corner of a box about the CoM with half edges `half` [m].
inline double LowestCorner(const Eigen::Vector3d& half, const Eigen::Vector3d& p_WB,
                           const Eigen::Matrix3d& R_WB) {
  return p_WB[2] - R_WB.row(2).cwiseAbs().dot(half);
}

/// The shapes of a cable robot: the platform as its PlatformBox, cables coloured by tension [N], anchors on
/// posts, springs, obstacles, payload, external force, and the path of the CoM. Cables are drawn thicker than
/// they are. Cables with mass are drawn in pieces with their sag, pulleys with their swivel.
Geometry MakeCdprGeometry(const CdprDescription& robot);

/// Moves the shapes that MakeCdprGeometry() made for the same robot. Does not allocate.
void MoveCdprGeometry(const CdprDescription& robot, const PlatformState& platform, const CableVector& tension,
                      const std::vector<CableStatics>& cables, const Payload& payload,
                      const PlatformWrench& wrench, Geometry* geometry);

}  // namespace tenon
