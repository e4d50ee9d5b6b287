#include <tenon/controllers/legged/observers/foot_force_estimate.h>

namespace tenon {

FootForces FootForceEstimate::CalcForces(const FootForces& shank, const JointMotion& joints,
                                         const Vec<4>& q_WB) const {
  const Eigen::Matrix3d R_WB = RotationFromQuaternion(q_WB);
  FootForces forces_W;
  for (int leg = 0; leg < kNumLegs; ++leg)
    forces_W[leg] = R_WB * (params.robot.PoseOfLeg(leg, joints.q).R_BJ[kJointsPerLeg - 1] * shank[leg]);
  return forces_W;
}

}  // namespace tenon
