#pragma once

#include <tenon/plants/model/quadruped_description.h>

namespace tenon::apps {

/// The mass that the drives of a quadruped can hold.
struct HeldMass {
  double mass = 0;    ///< including the robot's own [kg]
  double load = 0;    ///< the largest load beside the robot; 0 if even the robot is too heavy [kg]
  int joint = 0;      ///< joint whose torque limit determines it, see QuadrupedDescription::joint()
  double torque = 0;  ///< torque of this joint while the robot itself is held [N m]
};

/// Returns the mass that two legs hold in the nominal stance by vertical forces
/// at their feet. In a trot, two legs are in the air.
HeldMass HeldByTwoLegs(const QuadrupedDescription& robot);

/// Says that two legs, which hold `held`, cannot hold the robot, and which joint needs which torque.
std::string CannotHold(const QuadrupedDescription& robot, const HeldMass& held);

}  // namespace tenon::apps
