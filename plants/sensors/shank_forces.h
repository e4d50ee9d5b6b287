#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

struct ShankForcesParams {
  QuadrupedDescription robot;
};

/// Turns the forces on the feet from the world's axes into those of the shank that each foot is fixed to, in
/// which its sensor measures: f_J = R_WJ^T f_W. FootForceEstimate turns them back, by what a robot knows.
///
///     ports in  state   the true one
///               forces  of the ground on the feet, in W
///     port out  shank   the same, each in the axes of its leg's last body
class ShankForces final : public LeafSystem<ShankForcesParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> forces{this, {"forces"}};
  OutputPort<FootForces> shank{this, {"shank"}, Uses(state, forces), &ShankForces::CalcShank};

 private:
  FootForces CalcShank(const LeggedState& x, const FootForces& forces_W) const;
};

}  // namespace tenon
