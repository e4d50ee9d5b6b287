#pragma once

#include <string>

namespace tenon {

/// The place of a leg as its name gives it: 1 for front or left, -1 for rear or right, 0 if the name does not
/// say.
struct LegPlace {
  int front = 0;
  int left = 0;
};

/// Reads the place of a leg from the name of one of its links or joints: "front_left_hip", "FL_calf",
/// "leftRearLegMotor", "lh_foot".
LegPlace PlaceInName(const std::string& name);

}  // namespace tenon
