#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const QuadrupedDescription& model,
                                      const LocomotionProfile& profile, const FootSchedulerParams& gaits) {
  QuadrupedWalkParams params;
  params.world = world;
  params.locomotion = MakeLocomotion(model, profile, gaits);
  params.observer = MakeObserver(model, profile);
  return params;
}

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot) {
  const RobotScale scale = ScaleOf(robot);
  return MakeQuadrupedWalk(MakeQuadrupedWorld(robot), robot, LoadLocomotionProfile({"standard"}, scale),
                           LoadGaits({"standard"}, scale));
}

QuadrupedWalk::QuadrupedWalk(const QuadrupedWalkParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      observer(Add<DisturbanceObserver>("observer", params.observer)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.world.plant.robot})),
      view(Add<WalkView>("view", WalkViewParams{params.world.plant.robot})),
      state(AddEstimator(params.estimator)) {
  const OutputPort<FootForces>& foot_forces = AddFootForces(params.world);
  Connect(walk.command, locomotion.command);
  Connect(state, locomotion.state);
  Connect(foot_forces, locomotion.foot_forces);
  Connect(observer.wrench, locomotion.wrench);
  Connect(observer.leg_forces, locomotion.leg_forces);
  Connect(locomotion.torque, world.torque);
  ConnectObserver(foot_forces);
  ConnectEvaluation();
}

const OutputPort<LeggedState>& QuadrupedWalk::AddEstimator(
    const std::optional<LeggedStateEstimatorParams>& params) {
  if (!params) return world.state;
  estimator = &Add<LeggedStateEstimator>("estimator", *params);
  Connect(world.inertial, estimator->imu);
  Connect(world.joints, estimator->joints);
  Connect(locomotion.schedule, estimator->schedule);
  return estimator->state;
}

/// Adds the block that computes the foot forces in W, if the sensors do not measure them there.
const OutputPort<FootForces>& QuadrupedWalk::AddFootForces(const QuadrupedWorldParams& params) {
  const FootSensing sensing = params.hardware.foot_sensing;
  if (sensing == FootSensing::kWorld) return world.foot_forces;
  if (sensing == FootSensing::kNone) {
    FootForcesOfLegsParams of_legs{.robot = locomotion.whole_body.params.robot,
                                   .rate = locomotion.scheduler.params.rate};
    of_legs.initial = params.plant.initial;
    foot_forces_of_legs = &Add<FootForcesOfLegs>("foot_forces", of_legs);
    Connect(state, foot_forces_of_legs->state);
    Connect(world.measured_torque, foot_forces_of_legs->torque);
    Connect(locomotion.ground, foot_forces_of_legs->ground);
    return foot_forces_of_legs->forces;
  }
  FootForceEstimateParams turned{.robot = params.plant.robot, .rate = params.foot_sensor.rate};
  turned.initial_q_WB = params.plant.initial.q_WB;
  foot_force_estimate = &Add<FootForceEstimate>("foot_force_estimate", turned);
  Connect(world.foot_forces, foot_force_estimate->shank);
  Connect(world.joints, foot_force_estimate->joints);
  Connect(state, foot_force_estimate->state);
  return foot_force_estimate->forces;
}

void QuadrupedWalk::ConnectObserver(const OutputPort<FootForces>& foot_forces) {
  Connect(state, observer.state);
  Connect(world.measured_torque, observer.torque);
  Connect(foot_forces, observer.foot_forces);
  auto& last_ground = Add<UnitDelay<GroundPlane>>(
      "last_ground", UnitDelayParams<GroundPlane>{.rate = locomotion.ground_estimator.params.rate});
  Connect(locomotion.ground, last_ground.u);
  Connect(last_ground.y, observer.ground);
  if (estimator != nullptr) Connect(last_ground.y, estimator->ground);
  Connect(estimator != nullptr ? estimator->inertial : world.inertial, observer.imu);
}

void QuadrupedWalk::ConnectEvaluation() {
  Connect(world.state, view.state);
  Connect(locomotion.body, view.body);
  Connect(observer.wrench, view.wrench);
  Connect(observer.leg_forces, view.leg_forces);
  Connect(world.state, errors.state);
  Connect(state, errors.told);
  Connect(world.ground_forces, errors.foot_forces);
  Connect(locomotion.schedule, errors.schedule);
  Connect(locomotion.body, errors.body);
  Connect(locomotion.feet, errors.feet);
  Connect(locomotion.plan, errors.plan);
  Connect(world.external_torque, errors.external_torque);
}

}  // namespace tenon
