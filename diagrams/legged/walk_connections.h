#pragma once

#include <tenon/controllers/legged/evaluation/tracking_error.h>
#include <tenon/controllers/legged/evaluation/walk_view.h>
#include <tenon/plants/model/legged_signals.h>
#include <tenon/systems/framework/ports.h>

namespace tenon {

/// Connects what every diagram of a walking robot has: `locomotion`, `world` and `observer` with each other,
/// and `errors` and `view`, which look on. Locomotion and observer are told `state`, the other two the true
/// one. The command is left to connect.
void ConnectWalk(auto& walk, const OutputPort<LeggedState>& state) {
  walk.Connect(state, walk.locomotion.state);
  walk.Connect(walk.world.foot_forces, walk.locomotion.foot_forces);
  walk.Connect(walk.observer.wrench, walk.locomotion.wrench);
  walk.Connect(walk.observer.leg_forces, walk.locomotion.leg_forces);
  walk.Connect(walk.locomotion.torque, walk.world.torque);

  walk.Connect(state, walk.observer.state);
  walk.Connect(walk.world.measured_torque, walk.observer.torque);
  walk.Connect(walk.world.foot_forces, walk.observer.foot_forces);
  walk.Connect(walk.world.inertial, walk.observer.imu);

  walk.Connect(walk.world.state, walk.view.state);
  walk.Connect(walk.locomotion.body, walk.view.body);
  walk.Connect(walk.observer.wrench, walk.view.wrench);
  walk.Connect(walk.observer.leg_forces, walk.view.leg_forces);
  walk.Connect(walk.world.state, walk.errors.state);
  walk.Connect(walk.world.ground_forces, walk.errors.foot_forces);
  walk.Connect(walk.locomotion.schedule, walk.errors.schedule);
  walk.Connect(walk.locomotion.body, walk.errors.body);
  walk.Connect(walk.locomotion.feet, walk.errors.feet);
  walk.Connect(walk.locomotion.plan, walk.errors.plan);
  walk.Connect(walk.world.external_torque, walk.errors.external_torque);
}

}  // namespace tenon
