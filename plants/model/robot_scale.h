#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/systems/framework/types/scale.h>

namespace tenon {

/// The scale of a robot with legs. Its length is the mean length of the straight legs, from hip to foot.
using RobotScale = Scale;

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity = kGravity);

}  // namespace tenon
