#include "tenon/diagrams/guide_dog.h"

namespace tenon {

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
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.true_robot})) {
  Connect(walk.command, supervisor.command);
  Connect(observer.wrench, supervisor.wrench);
  Connect(world.state, supervisor.state);
  Connect(obstacles.obstacle, supervisor.obstacle);

  Connect(supervisor.walk, admittance.command);
  Connect(observer.wrench, admittance.wrench);
  Connect(world.state, admittance.state);

  Connect(admittance.walk, locomotion.command);
  Connect(world.state, locomotion.state);
  Connect(world.foot_forces, locomotion.foot_forces);
  Connect(observer.wrench, locomotion.wrench);
  Connect(observer.leg_forces, locomotion.leg_forces);
  Connect(locomotion.torque, world.torque);

  Connect(world.state, observer.state);
  Connect(world.measured_torque, observer.torque);
  Connect(world.foot_forces, observer.foot_forces);
  Connect(world.inertial, observer.imu);

  Connect(world.state, obstacles.state);
  Connect(world.state, leash.robot);
  Connect(person.person, leash.person);
  Connect(leash.leash, person.leash);
  Connect(leash.force, world.pull);

  Connect(world.state, errors.state);
  Connect(world.ground_forces, errors.foot_forces);
  Connect(locomotion.schedule, errors.schedule);
  Connect(locomotion.body, errors.body);
  Connect(locomotion.feet, errors.feet);
  Connect(locomotion.plan, errors.plan);
}

}  // namespace tenon
