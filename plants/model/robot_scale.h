#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

/// Scales for dynamically similar robots (Alexander 1984, The gaits of bipedal and quadrupedal animals): mass
/// m, leg length l, gravity g and derived units. Gains given in these units suit robots of all sizes.
struct RobotScale {
  double mass = 1;            ///< m [kg]
  double length = 1;          ///< l: mean length of the straight legs, from hip to foot [m]
  double gravity = kGravity;  ///< g [m/s^2]

  double Weight() const { return mass * gravity; }  ///< m g [N]
  double Time() const;                              ///< t = sqrt(l / g) [s]
};

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity = kGravity);

}  // namespace tenon
