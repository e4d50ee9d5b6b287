#pragma once

#include "tenon/systems/signal.h"

namespace tenon {

/// A point of a motion in the plane, in W.
struct PlanarPoint {
  Vec<2> position = Vec<2>::Zero();      ///< x [m]
  Vec<2> velocity = Vec<2>::Zero();      ///< x' [m/s]
  Vec<2> acceleration = Vec<2>::Zero();  ///< x'' [m/s^2]
};

}  // namespace tenon
