#pragma once

#include <cmath>

namespace tenon {

/// Scales for dynamically similar systems (Alexander 1984, The gaits of bipedal and quadrupedal animals):
/// mass m, length l, gravity g and derived units. Gains given in these units suit systems of all sizes.
struct Scale {
  double mass = 1;        ///< m [kg]
  double length = 1;      ///< l [m]
  double gravity = 9.81;  ///< g [m/s^2]
  double arm = 1;         ///< a, of a platform: root mean square distance of the attachments from the CoM [m]

  double Weight() const { return mass * gravity; }             ///< m g [N]
  double Time() const { return std::sqrt(length / gravity); }  ///< t = sqrt(l / g) [s]
};

}  // namespace tenon
