#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

/// The units in which robots of all sizes walk alike: mass m, leg length l and gravity g, and what follows
/// from them. Two robots whose motions agree in these units are dynamically similar, as Alexander (1984, The
/// gaits of bipedal and quadrupedal animals) has it of animals; a gain that is given in them fits both.
struct RobotScale {
  double mass = 1;            ///< m [kg]
  double length = 1;          ///< l: mean over the legs, from hip to foot when straight [m]
  double gravity = kGravity;  ///< g [m/s^2]

  double Weight() const { return mass * gravity; }  ///< m g [N]
  double Time() const;                              ///< t = sqrt(l / g) [s]
};

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity = kGravity);

}  // namespace tenon
