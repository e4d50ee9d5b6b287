#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// @file
/// What a person on a leash and the leash put out. W is the world, z up. SI units.

/// Where a person is and goes. Floors are level: z is 0 but for the hand.
struct PersonState {
  Vec<3> p_W = Vec<3>::Zero();     ///< [m]
  Vec<3> v_W = Vec<3>::Zero();     ///< [m/s]
  Vec<3> hand_W = Vec<3>::Zero();  ///< that holds the leash, and moves with v_W [m]

  static FieldList Fields() {
    return {{"p_W", &PersonState::p_W, "m"},
            {"v_W", &PersonState::v_W, "m/s"},
            {"hand_W", &PersonState::hand_W, "m"}};
  }
};

/// A leash between the hand of a person and a robot. It pulls the hand by tension * direction_W, the robot by
/// the opposite.
struct LeashState {
  double length = 0;   ///< between its ends [m]
  double tension = 0;  ///< 0 or more [N]
  Vec<3> direction_W =
      Vec<3>::Zero();  ///< unit vector from the hand to the robot; 0 if they are in one place

  static FieldList Fields() {
    return {{"length", &LeashState::length, "m"},
            {"tension", &LeashState::tension, "N"},
            {"direction_W", &LeashState::direction_W}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PersonState);
TENON_DECLARE_SIGNAL(tenon::LeashState);
