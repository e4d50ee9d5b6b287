#pragma once

#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// How far a drum has turned to wind up a length of cable, and on which radius the cable lies now.
///
/// Each layer has N turns; those of the next lie in the grooves between them, so that the radius grows by
/// sqrt(3)/2 of the cable's diameter D from layer to layer:
///
///     r_k = r + k D sqrt(3)/2,   layer k holds 2 pi r_k N,
///
/// and the angle is continuous, with the slope 1/r_k. The pitch of the helix, of the order (D / 2 pi r)^2, is
/// neglected.
struct DrumTurn {
  double angle = 0;   ///< since the drum was empty [rad]
  double radius = 0;  ///< [m]
};

/// Of the length `wound` [m], not negative.
DrumTurn TurnOf(const DrumProperties& drum, double wound);

}  // namespace tenon
