#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct FootForceEstimateParams {
  QuadrupedDescription robot;
  Rate rate = Hz(1000);
  Vec<4> initial_q_WB{1, 0, 0, 0};  ///< attitude at the first tick
};

/// Foot forces in the axes of W from force sensors in the shanks: f_W = R_WB R_BJ(q) f_J. R_WB is the
/// estimated attitude of the previous tick, since the estimate of this tick depends on which feet stand, and
/// these depend on the forces.
class FootForceEstimate final : public LeafSystem<FootForceEstimateParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<FootForces> shank{this, {"shank"}};
  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<LeggedState> state{this, {"state"}};

 private:
  DiscreteState<Vec<4>> q_WB_{this, {"q_WB", "", "w,x,y,z"}, params.initial_q_WB};
  Update<Vec<4>> next_{q_WB_, Sampled{params.rate}, Uses(state),
                       [](const LeggedState& state_now) -> const Vec<4>& { return state_now.q_WB; }};

 public:
  OutputPort<FootForces> forces{this, {"forces"}, Uses(shank, joints, q_WB_), &FootForceEstimate::CalcForces};

 private:
  FootForces CalcForces(const FootForces& shank, const JointMotion& joints, const Vec<4>& q_WB) const {
    const Eigen::Matrix3d R_WB = RotationFromQuaternion(q_WB);
    FootForces forces_W;
    for (int leg = 0; leg < kNumLegs; ++leg)
      forces_W[leg] = R_WB * (params.robot.PoseOfLeg(leg, joints.q).R_BJ[kJointsPerLeg - 1] * shank[leg]);
    return forces_W;
  }
};

}  // namespace tenon
