#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/walk_connections.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

GuideDogParams MakeGuideDog(const QuadrupedWalkParams& walk) {
  GuideDogParams params;
  params.world = walk.world;
  params.walk = walk.walk;
  params.locomotion = walk.locomotion;
  params.observer = walk.observer;
  params.estimator = walk.estimator;
  return params;
}

GuideDog::GuideDog(const GuideDogParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      supervisor(Add<Supervisor>("supervisor", params.supervisor)),
      admittance(Add<AdmittanceFilter>("admittance", params.admittance)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      observer(Add<DisturbanceObserver>("observer", params.observer)),
      obstacles(Add<ObstacleDetector>("obstacles", params.obstacles)),
      person(Add<Person>("person", params.person)),
      leash(Add<Leash>("leash", params.leash)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.world.plant.robot})),
      view(Add<WalkView>("view", WalkViewParams{params.world.plant.robot})) {
  if (params.estimator) {
    auto& last = Add<UnitDelay<ContactSchedule>>(
        "last_schedule", UnitDelayParams<ContactSchedule>{.rate = params.estimator->rate});
    estimator = &Add<LeggedStateEstimator>("estimator", *params.estimator);
    Connect(locomotion.schedule, last.u);
    Connect(last.y, estimator->schedule);
    Connect(world.inertial, estimator->imu);
    Connect(world.joints, estimator->joints);
  }
  const OutputPort<LeggedState>& state = estimator ? estimator->state : world.state;

  Connect(walk.command, supervisor.command);
  Connect(observer.wrench, supervisor.wrench);
  Connect(state, supervisor.state);
  Connect(obstacles.obstacle, supervisor.obstacle);

  Connect(supervisor.walk, admittance.command);
  Connect(observer.wrench, admittance.wrench);
  Connect(state, admittance.state);

  Connect(admittance.walk, locomotion.command);
  ConnectWalk(*this, state, ConnectFootForces(*this, params, state));

  Connect(world.state, obstacles.state);
  Connect(world.state, leash.robot);
  Connect(person.person, leash.person);
  Connect(leash.leash, person.leash);
  Connect(leash.force, world.pull);
}

}  // namespace tenon
