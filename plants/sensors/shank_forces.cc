#include <tenon/plants/sensors/shank_forces.h>

namespace tenon {

FootForces ShankForces::CalcShank(const LeggedState& x, const FootForces& forces_W) const {
  const Eigen::Matrix3d R_WB = x.R_WB();
  FootForces forces_J;
  for (int leg = 0; leg < kNumLegs; ++leg)
    forces_J[leg] =
        (R_WB * params.robot.PoseOfLeg(leg, x.q).R_BJ[kJointsPerLeg - 1]).transpose() * forces_W[leg];
  return forces_J;
}

}  // namespace tenon
