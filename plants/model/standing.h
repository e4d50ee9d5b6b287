#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

/// A robot at rest on a plane, with B's origin near the plane's point p_W, the trunk parallel to the plane,
/// and this heading [rad]. Seen from above, the feet have their positions of the nominal stance relative to
/// the trunk, and the CoM its nominal height: on a slope, too, the legs are vertical and the CoM is above the
/// centre of the feet. `feet_shift` displaces the feet horizontally from there [m]. Throws ParameterError if
/// a leg does not reach the ground within the ranges of its joints.
LeggedState StandingOn(const QuadrupedDescription& robot, const GroundPlane& ground, double yaw = 0,
                       const Vec<2>& feet_shift = Vec<2>::Zero());

}  // namespace tenon
