#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

/// A robot at rest on a plane, B's origin near its point p_W: the trunk is parallel to it, with this heading
/// [rad]; seen from above, the feet are where they are below the trunk in the nominal stance, and the CoM as
/// high over the ground. So legs hang vertically on a slope too, and the CoM stays over the middle of the
/// feet. Throws ParameterError if a leg does not reach the ground.
LeggedState StandingOn(const QuadrupedDescription& robot, const GroundPlane& ground, double yaw = 0);

}  // namespace tenon
