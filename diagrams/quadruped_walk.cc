#include "tenon/diagrams/quadruped_walk.h"

namespace tenon {

QuadrupedWalk::QuadrupedWalk(const QuadrupedWalkParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.true_robot})) {
  Connect(walk.command, locomotion.command);
  if (params.estimator) {
    estimator = &Add<LeggedStateEstimator>("estimator", *params.estimator);
    Connect(world.inertial, estimator->imu);
    Connect(world.joints, estimator->joints);
    Connect(locomotion.schedule, estimator->schedule);
    Connect(estimator->state, locomotion.state);
  } else {
    Connect(world.state, locomotion.state);
  }
  Connect(world.foot_forces, locomotion.foot_forces);
  Connect(locomotion.torque, world.torque);

  Connect(world.state, errors.state);
  Connect(world.ground_forces, errors.foot_forces);
  Connect(locomotion.schedule, errors.schedule);
  Connect(locomotion.body, errors.body);
  Connect(locomotion.feet, errors.feet);
  Connect(locomotion.plan, errors.plan);
}

}  // namespace tenon
