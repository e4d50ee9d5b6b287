#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/multibody/extended_robot.h>

namespace tenon {

class CdprMultibody;

/// Adds to a cable robot's multibody system, see cdpr_multibody.h.
using ExtendCdpr = std::function<void(CdprMultibody&)>;

/// Acceleration and d q_WB / dt of a platform, and rates of the added states.
struct PlatformRates : AddedRates {
  PlatformAcceleration platform;
  Vec<4> quaternion = Vec<4>::Zero();
  // With ExtendedRobot a multiple of 16 bytes: what a plant adds to a context shall not move the alignment of
  // other values, on which the last digits of Eigen's sums depend.
  double unused = 0;
};
static_assert((sizeof(PlatformRates) + sizeof(ExtendedRobot)) % 16 == 0);

/// The platform of a cable robot with additions; no robot if `extend` is empty. Throws ParameterError as
/// ExtendedRobot does.
ExtendedRobot ExtendedPlatform(const CdprDescription& robot, double gravity, const ExtendCdpr& extend,
                               const PlatformState& initial);

}  // namespace tenon
