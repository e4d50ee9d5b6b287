#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/legged/walk_connections.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const LocomotionProfile& profile,
                                      const QuadrupedDescription& believed) {
  QuadrupedWalkParams params;
  params.world = world;
  params.locomotion = MakeLocomotion(believed, profile);
  params.locomotion.scheduler = LoadGaits({"standard"}, ScaleOf(world.plant.robot));
  params.observer = MakeObserver(believed, profile);
  return params;
}

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot, const LocomotionProfile& profile) {
  return MakeQuadrupedWalk(MakeQuadrupedWorld(robot), profile, robot);
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
