#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/systems/block.h>

struct MomentumObserverParams {
  tenon::QuadrupedDescription robot;  // masses and lengths, as the observer knows them
  double bandwidth = 25;              // K [rad/s]
  tenon::Rate rate = tenon::Hz(1000);
  void Validate() const { tenon::Demand(bandwidth > 0, "bandwidth must be positive"); }
};

// Estimates the net force on a quadruped from its linear momentum; torques and forces on the legs are zero.
class MomentumObserver final : public tenon::LeafSystem<MomentumObserverParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::LeggedState> state{this, {"state"}};
  tenon::InputPort<tenon::FootForces> foot_forces{this, {"foot_forces"}};
  tenon::DiscreteState<tenon::Vec<3>> momentum{this, {"momentum", "kg m/s"}};  // p

  tenon::Shared<tenon::QuadrupedDynamics> dynamics{this, "dynamics", tenon::Uses(state),
                                                   tenon::QuadrupedModel(params.robot)};
  tenon::OutputPort<tenon::WrenchEstimate> wrench{this,
                                                  {"wrench"},
                                                  tenon::Sampled{params.rate},
                                                  tenon::Uses(dynamics, momentum),
                                                  &MomentumObserver::CalcWrench};
  tenon::OutputPort<tenon::LegForceEstimate> leg_forces{
      this, {"leg_forces"}, tenon::Uses(), [] { return tenon::LegForceEstimate(); }};
  tenon::Update<tenon::Vec<3>> next{momentum, tenon::Sampled{params.rate},
                                    tenon::Uses(momentum, foot_forces, wrench), &MomentumObserver::CalcNext};

 private:
  tenon::WrenchEstimate CalcWrench(const tenon::QuadrupedDynamics& dynamics,
                                   const tenon::Vec<3>& momentum) const {
    tenon::WrenchEstimate estimate;
    estimate.force_W = params.bandwidth * (model_.mass() * dynamics.com_velocity_W - momentum);
    return estimate;
  }
  tenon::Vec<3> CalcNext(const tenon::Vec<3>& momentum, const tenon::FootForces& foot_forces,
                         const tenon::WrenchEstimate& wrench) const {
    tenon::Vec<3> force = wrench.force_W;
    for (int leg = 0; leg < tenon::kNumLegs; ++leg) force += foot_forces[leg];
    force[2] -= model_.mass() * model_.gravity();
    return momentum + params.rate.period() * force;
  }

  const tenon::QuadrupedModel model_{params.robot};
};
