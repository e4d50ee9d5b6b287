#pragma once

#include <tenon/plants/cdpr/extended_platform.h>
#include <tenon/plants/legged/extended_quadruped.h>
#include <tenon/plants/model/attached_body.h>

namespace tenon {

/// Inertia of a uniform box whose edges [m] are parallel to the axes: I_x = m (b^2 + c^2) / 12.
RigidInertia UniformBoxInertia(double mass, const Eigen::Vector3d& centre, const Eigen::Vector3d& edges);

/// Returns a function for QuadrupedPlantParams::extend that attaches bodies to the robot and draws them. The
/// function throws ParameterError for an unknown `on`, with the nearest name, and for a name used twice. The
/// bodies replace the part `replaced` of the trunk, given in B, see RobotMultibody::Replace; none by default.
ExtendQuadruped Attach(std::vector<AttachedBody> bodies, const RigidInertia& replaced = {});

/// Does the same as Attach for CdprPlantParams::extend: bodies on the platform of a cable robot.
ExtendCdpr AttachToPlatform(std::vector<AttachedBody> bodies);

}  // namespace tenon
