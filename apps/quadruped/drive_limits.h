#pragma once

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/report/report.h>

#include <vector>

namespace tenon::apps {

/// Limits of torque and speed of each joint [N m, rad/s], in both directions.
std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant);

}  // namespace tenon::apps
