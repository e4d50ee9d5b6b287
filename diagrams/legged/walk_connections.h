#pragma once

#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

/// Connects what every diagram of a walking robot has: `locomotion`, `world` and `observer` with each other,
/// and `errors` and `view`, which look on. Locomotion and observer are told `state` and `foot_forces`, the
/// other two the true ones, and the ground that was felt a tick ago. The command is left to connect.
void ConnectWalk(auto& walk, const OutputPort<LeggedState>& state,
                 const OutputPort<FootForces>& foot_forces) {
  walk.Connect(state, walk.locomotion.state);
  walk.Connect(foot_forces, walk.locomotion.foot_forces);
  walk.Connect(walk.observer.wrench, walk.locomotion.wrench);
  walk.Connect(walk.observer.leg_forces, walk.locomotion.leg_forces);
  walk.Connect(walk.locomotion.torque, walk.world.torque);

  walk.Connect(state, walk.observer.state);
  walk.Connect(walk.world.measured_torque, walk.observer.torque);
  walk.Connect(foot_forces, walk.observer.foot_forces);
  auto& last_ground = walk.template Add<UnitDelay<GroundPlane>>(
      "last_ground", UnitDelayParams<GroundPlane>{.rate = walk.locomotion.ground_estimator.params.rate});
  walk.Connect(walk.locomotion.ground, last_ground.u);
  walk.Connect(last_ground.y, walk.observer.ground);
  if (walk.estimator) walk.Connect(last_ground.y, walk.estimator->ground);
  walk.Connect(walk.estimator ? walk.estimator->inertial : walk.world.inertial, walk.observer.imu);

  walk.Connect(walk.world.state, walk.view.state);
  walk.Connect(walk.locomotion.body, walk.view.body);
  walk.Connect(walk.observer.wrench, walk.view.wrench);
  walk.Connect(walk.observer.leg_forces, walk.view.leg_forces);
  walk.Connect(walk.world.state, walk.errors.state);
  walk.Connect(state, walk.errors.told);
  walk.Connect(walk.world.ground_forces, walk.errors.foot_forces);
  walk.Connect(walk.locomotion.schedule, walk.errors.schedule);
  walk.Connect(walk.locomotion.body, walk.errors.body);
  walk.Connect(walk.locomotion.feet, walk.errors.feet);
  walk.Connect(walk.locomotion.plan, walk.errors.plan);
  walk.Connect(walk.world.external_torque, walk.errors.external_torque);
}

/// The forces on the feet in W: as the world gives them, or, from sensors in the shanks, by the walk's
/// `foot_force_estimate`, or, without any, by its `foot_forces_of_legs`; the one that is needed is added.
const OutputPort<FootForces>& ConnectFootForces(auto& walk, const auto& params,
                                                const OutputPort<LeggedState>& state) {
  const FootSensing sensing = params.world.hardware.foot_sensing;
  if (sensing == FootSensing::kWorld) return walk.world.foot_forces;
  if (sensing == FootSensing::kNone) {
    FootForcesOfLegsParams of_legs{.robot = walk.locomotion.whole_body.params.robot,
                                   .rate = walk.locomotion.scheduler.params.rate};
    of_legs.initial = params.world.plant.initial;
    auto& legs = walk.template Add<FootForcesOfLegs>("foot_forces", of_legs);
    walk.foot_forces_of_legs = &legs;
    walk.Connect(state, legs.state);
    walk.Connect(walk.world.measured_torque, legs.torque);
    walk.Connect(walk.locomotion.ground, legs.ground);
    return legs.forces;
  }
  FootForceEstimateParams turned{.robot = params.world.plant.robot, .rate = params.world.foot_sensor.rate};
  turned.initial_q_WB = params.world.plant.initial.q_WB;
  auto& estimate = walk.template Add<FootForceEstimate>("foot_force_estimate", turned);
  walk.foot_force_estimate = &estimate;
  walk.Connect(walk.world.foot_forces, estimate.shank);
  walk.Connect(walk.world.joints, estimate.joints);
  walk.Connect(state, estimate.state);
  return estimate.forces;
}

}  // namespace tenon
