#pragma once

#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// Angle of a drum that has wound up a length of cable, and the radius of its current layer.
///
/// Each layer has N turns. The turns of the next layer lie in the grooves between them, so the radius
/// increases by sqrt(3)/2 of the cable's diameter D from layer to layer:
///
///     r_k = r + k D sqrt(3)/2,   layer k holds 2 pi r_k N,
///
/// and the angle is continuous, with the slope 1/r_k. The pitch of the helix, of the order (D / 2 pi r)^2, is
/// neglected.
struct DrumTurn {
  double angle = 0;   ///< since the drum was empty [rad]
  double radius = 0;  ///< [m]
};

/// Turn of a drum that has wound up the length `wound` >= 0 [m].
DrumTurn TurnOf(const DrumProperties& drum, double wound);

}  // namespace tenon
