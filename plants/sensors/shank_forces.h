#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct ShankForcesParams {
  QuadrupedDescription robot;
};

/// Transforms the ground forces from W to the axes of the shanks, in which the foot sensors measure: f_J =
/// R_WJ^T f_W. FootForceEstimate computes the inverse from estimated states.
class ShankForces final : public LeafSystem<ShankForcesParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> forces{this, {"forces"}};
  OutputPort<FootForces> shank{this, {"shank"}, Uses(state, forces), &ShankForces::CalcShank};

 private:
  FootForces CalcShank(const LeggedState& x, const FootForces& forces_W) const {
    const Eigen::Matrix3d R_WB = x.R_WB();
    FootForces forces_J;
    for (int leg = 0; leg < kNumLegs; ++leg)
      forces_J[leg] =
          (R_WB * params.robot.PoseOfLeg(leg, x.q).R_BJ[kJointsPerLeg - 1]).transpose() * forces_W[leg];
    return forces_J;
  }
};

}  // namespace tenon
