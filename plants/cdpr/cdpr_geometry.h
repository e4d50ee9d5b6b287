#pragma once

#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/geometry.h>

#include <vector>

namespace tenon {

/// What a cable robot looks like: the platform as a box that its attachments span about the CoM, the cables
/// coloured by tension [N], anchors on posts, payload, external force, and the path of the CoM. Cables are
/// drawn thicker than they are, to be seen from afar; those with mass in pieces, as they sag; pulleys with
/// their swivel.
Geometry MakeCdprGeometry(const CdprDescription& robot);

/// Moves the shapes that MakeCdprGeometry made for the same robot; allocates nothing.
void MoveCdprGeometry(const CdprDescription& robot, const PlatformState& platform, const CableVector& tension,
                      const std::vector<CableStatics>& cables, const Payload& payload,
                      const PlatformWrench& wrench, Geometry* geometry);

}  // namespace tenon
