#include "tenon/diagrams/quadruped_walk.h"

namespace tenon {

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot, const LocomotionProfile& profile) {
  QuadrupedWalkParams params;
  params.true_robot = robot;
  params.world.plant.robot = robot;
  params.world.plant.initial.p_WB[2] = robot.StanceHeight();
  params.world.plant.initial.q = robot.stance;
  params.world.min_height = 0.5 * robot.StanceHeight();
  params.locomotion = MakeLocomotion(robot, profile);
  params.observer = MakeObserver(robot, profile);
  return params;
}

QuadrupedWalk::QuadrupedWalk(const QuadrupedWalkParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      observer(Add<DisturbanceObserver>("observer", params.observer)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.true_robot})),
      view(Add<WalkView>("view", WalkViewParams{params.true_robot})) {
  Connect(walk.command, locomotion.command);
  if (params.estimator) {
    estimator = &Add<LeggedStateEstimator>("estimator", *params.estimator);
    Connect(world.inertial, estimator->imu);
    Connect(world.joints, estimator->joints);
    Connect(locomotion.schedule, estimator->schedule);
    Connect(estimator->state, locomotion.state);
    Connect(estimator->state, observer.state);
  } else {
    Connect(world.state, locomotion.state);
    Connect(world.state, observer.state);
  }
  Connect(world.measured_torque, observer.torque);
  Connect(world.foot_forces, observer.foot_forces);
  Connect(world.inertial, observer.imu);
  Connect(observer.wrench, locomotion.wrench);
  Connect(observer.leg_forces, locomotion.leg_forces);
  Connect(world.foot_forces, locomotion.foot_forces);
  Connect(locomotion.torque, world.torque);

  Connect(world.state, view.state);
  Connect(locomotion.body, view.body);
  Connect(observer.wrench, view.wrench);
  Connect(observer.leg_forces, view.leg_forces);
  Connect(world.state, errors.state);
  Connect(world.ground_forces, errors.foot_forces);
  Connect(locomotion.schedule, errors.schedule);
  Connect(locomotion.body, errors.body);
  Connect(locomotion.feet, errors.feet);
  Connect(locomotion.plan, errors.plan);
}

}  // namespace tenon
