#include <tenon/diagrams/legged/quadruped_walk.h>

#include <tenon/diagrams/legged/walk_connections.h>

namespace tenon {

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot, const LocomotionProfile& profile) {
  QuadrupedWalkParams params;
  params.world.plant.robot = robot;
  params.world.plant.initial.p_WB[2] = robot.StanceHeight();
  params.world.plant.initial.q = robot.stance;
  params.world.min_height = 0.5 * robot.StanceHeight();
  params.locomotion = MakeLocomotion(robot, profile);
  params.observer = MakeObserver(robot, profile);
  return params;
}

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot) {
  return MakeQuadrupedWalk(robot, LoadLocomotionProfile("standard", ScaleOf(robot)));
}

QuadrupedWalk::QuadrupedWalk(const QuadrupedWalkParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      observer(Add<DisturbanceObserver>("observer", params.observer)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.world.plant.robot})),
      view(Add<WalkView>("view", WalkViewParams{params.world.plant.robot})) {
  Connect(walk.command, locomotion.command);
  if (params.estimator) {
    estimator = &Add<LeggedStateEstimator>("estimator", *params.estimator);
    Connect(world.inertial, estimator->imu);
    Connect(world.joints, estimator->joints);
    Connect(locomotion.schedule, estimator->schedule);
  }
  const OutputPort<LeggedState>& state = estimator ? estimator->state : world.state;
  ConnectWalk(*this, state, ConnectFootForces(*this, params, state));
}

}  // namespace tenon
