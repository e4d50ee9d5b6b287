#pragma once

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/report/report.h>

#include <vector>

namespace tenon::apps {

/// What the drives of a robot can do: the torque and the speed of each joint [N m, rad/s], both ways.
std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant);

}  // namespace tenon::apps
