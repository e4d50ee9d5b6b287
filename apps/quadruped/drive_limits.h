#pragma once

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/report/report.h>

#include <vector>

namespace tenon::apps {

/// The parameters of the plant that stands in the diagram, see CurrentAs.
inline const QuadrupedPlantParams& ParamsOf(const QuadrupedPlant& plant) {
  return CurrentAs<LeafSystem<QuadrupedPlantParams>>(plant).params;
}

/// Limits of torque and speed of each joint [N m, rad/s], in both directions; none if they are unknown.
std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant);

}  // namespace tenon::apps
