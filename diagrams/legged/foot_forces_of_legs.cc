#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

FootForcesOfLegs::FootForcesOfLegs(const FootForcesOfLegsParams& params)
    : legs(Add<LegMomentumObserver>(
          "legs",
          LegMomentumObserverParams{.robot = params.robot, .gains = params.gains, .rate = params.rate})),
      ground_forces(Add<GroundForceObserver>(
          "ground_forces", GroundForceObserverParams{.robot = params.robot,
                                                     .thresholds = params.thresholds,
                                                     .min_singular_value = params.gains.min_singular_value,
                                                     .rate = params.rate})) {
  auto& last_state = Add<UnitDelay<LeggedState>>(
      "last_state", UnitDelayParams<LeggedState>{.initial = params.initial, .rate = params.rate});
  auto& last_torque =
      Add<UnitDelay<Vec<12>>>("last_torque", UnitDelayParams<Vec<12>>{.rate = params.rate, .unit = "N m"});
  auto& last_ground =
      Add<UnitDelay<GroundPlane>>("last_ground", UnitDelayParams<GroundPlane>{.rate = params.rate});
  Connect(state, last_state.u);
  Connect(torque, last_torque.u);
  Connect(ground, last_ground.u);

  Connect(last_state.y, legs.state);
  Connect(last_torque.y, legs.torque);
  Connect(Add<ConstantSource<FootForces>>("no_foot_forces").y, legs.foot_forces);
  Connect(last_state.y, ground_forces.state);
  Connect(legs.estimate, ground_forces.leg_forces);
  Connect(last_ground.y, ground_forces.ground);
  Connect(ground_forces.forces, forces);
}

}  // namespace tenon
