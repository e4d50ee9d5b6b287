#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/multibody/robot_multibody.h>

namespace tenon {

/// The platform of a cable robot in Simbody, to which CdprPlantParams::extend adds, as in the example of
/// QuadrupedMultibody. robot_multibody.h is the guide: what is possible and what is not, names and
/// coordinates of added joints, threads. See CdprPlant for what follows from an addition.
///
/// **Bodies and frames.** Ground is W. The platform is the only body; its frame is B, at the CoM of the
/// platform without additions. The cables have no bodies: they, the payload and the external wrench are
/// forces of the plant, so nothing can be added to a cable or a winch, and added bodies pass through cables.
///
/// **Cost.** In processor time of one core (AMD EPYC), the scenario D1 runs at 76 times real time, and
/// D1-arm, with two added joints, at 25.
class CdprMultibody final : public RobotMultibody {
 public:
  /// The platform under gravity [m/s^2].
  CdprMultibody(const CdprDescription& robot, double gravity)
      : RobotMultibody({robot.mass, Eigen::Vector3d::Zero(), robot.inertia_B}, gravity) {}

  SimTK::MobilizedBody& platform() { return base(); }
};

}  // namespace tenon
