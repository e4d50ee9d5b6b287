#include <tenon/diagrams/guide_dog/guide_dog.h>

namespace tenon {

GuideDogParams MakeGuideDog(const QuadrupedWalkParams& walk) {
  GuideDogParams params;
  static_cast<QuadrupedWalkParams&>(params) = walk;
  return params;
}

GuideDog::GuideDog(const GuideDogParams& params)
    : QuadrupedWalk(params),
      supervisor(Add<Supervisor>("supervisor", params.supervisor)),
      admittance(Add<AdmittanceFilter>("admittance", params.admittance)),
      obstacles(Add<ObstacleDetector>("obstacles", params.obstacles)),
      person(Add<Person>("person", params.person)),
      leash(Add<Leash>("leash", params.leash)) {
  Disconnect(locomotion.command);
  Connect(walk.command, supervisor.command);
  Connect(observer.wrench, supervisor.wrench);
  Connect(state, supervisor.state);
  Connect(obstacles.in_sight, supervisor.obstacle);
  Connect(world.state, obstacles.state);

  Connect(supervisor.walk, admittance.command);
  Connect(observer.wrench, admittance.wrench);
  Connect(state, admittance.state);
  Connect(admittance.walk, locomotion.command);

  Connect(world.state, leash.robot);
  Connect(person.person, leash.person);
  Connect(leash.leash, person.leash);
  Connect(leash.force, world.pull);

  if (estimator == nullptr) return;
  // Breaks the algebraic loop estimator, admittance, locomotion, estimator.
  auto& last = Add<UnitDelay<ContactSchedule>>(
      "last_schedule", UnitDelayParams<ContactSchedule>{.rate = estimator->params.rate});
  Disconnect(estimator->schedule);
  Connect(locomotion.schedule, last.u);
  Connect(last.y, estimator->schedule);
}

}  // namespace tenon
