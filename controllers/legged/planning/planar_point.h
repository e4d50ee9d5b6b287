#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Point of a motion in the plane, in W.
struct PlanarPoint {
  Vec<2> position = Vec<2>::Zero();      ///< x [m]
  Vec<2> velocity = Vec<2>::Zero();      ///< x' [m/s]
  Vec<2> acceleration = Vec<2>::Zero();  ///< x'' [m/s^2]

  static FieldList Fields() {
    return {{"position", &PlanarPoint::position, "m"},
            {"velocity", &PlanarPoint::velocity, "m/s"},
            {"acceleration", &PlanarPoint::acceleration, "m/s^2"}};
  }
};

}  // namespace tenon
