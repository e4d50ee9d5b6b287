#pragma once

#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/geometry.h>

#include <vector>

namespace tenon {

/// The shapes of a cable robot: the platform as the bounding box of its attachments and its CoM, cables
/// coloured by tension [N], anchors on posts, payload, external force, and the path of the CoM. Cables are
/// drawn thicker than they are. Cables with mass are drawn in pieces with their sag, pulleys with their
/// swivel.
Geometry MakeCdprGeometry(const CdprDescription& robot);

/// Moves the shapes that MakeCdprGeometry() made for the same robot. Does not allocate.
void MoveCdprGeometry(const CdprDescription& robot, const PlatformState& platform, const CableVector& tension,
                      const std::vector<CableStatics>& cables, const Payload& payload,
                      const PlatformWrench& wrench, Geometry* geometry);

}  // namespace tenon
