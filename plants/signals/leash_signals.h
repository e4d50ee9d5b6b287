#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// @file
/// Signals of a leash and the person who holds it. W is the world, z up. SI units.

/// Motion of a person on a level floor: z is 0 except for the hand.
struct PersonState {
  Vec<3> p_W = Vec<3>::Zero();     ///< [m]
  Vec<3> v_W = Vec<3>::Zero();     ///< [m/s]
  Vec<3> hand_W = Vec<3>::Zero();  ///< hand that holds the leash, moving with v_W [m]

  static FieldList Fields() {
    return {{"p_W", &PersonState::p_W, "m"},
            {"v_W", &PersonState::v_W, "m/s"},
            {"hand_W", &PersonState::hand_W, "m"}};
  }
};

/// State of a leash between a person's hand and a robot. The force on the hand is tension * direction_W, that
/// on the robot its opposite.
struct LeashState {
  double length = 0;                    ///< between its ends [m]
  double tension = 0;                   ///< at least 0 [N]
  Vec<3> direction_W = Vec<3>::Zero();  ///< unit vector from the hand to the robot; 0 if they coincide

  static FieldList Fields() {
    return {{"length", &LeashState::length, "m"},
            {"tension", &LeashState::tension, "N"},
            {"direction_W", &LeashState::direction_W}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PersonState);
TENON_DECLARE_SIGNAL(tenon::LeashState);
