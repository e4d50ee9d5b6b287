#include <tenon/controllers/legged/observers/com_observer.h>

#include <Eigen/Geometry>

namespace tenon {

void ComObserverParams::Validate() const {
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
}

WrenchEstimate ComObserver::CalcEstimate(const LeggedState& state, const QuadrupedDynamics& dynamics,
                                         const FootForces& foot_forces, const GroundPlane& ground,
                                         const Vec<3>& specific_force_W, const WrenchEstimate& known,
                                         const ComObserverGains& gains, Memory& memory) const {
  const bool from_imu = gains.force_source == ForceSource::kImu;
  const double mass = model_.mass(), period = params.rate.period();
  const Vec<3> weight(0, 0, mass * model_.gravity());

  const Memory before = memory;
  memory.started = true;
  memory.force_source = gains.force_source;
  memory.linear = mass * dynamics.com_velocity_W;
  if (from_imu) memory.linear -= mass * (state.v_W + state.w_W.cross(state.R_WB() * params.robot.imu_B));
  memory.angular = dynamics.angular_momentum_W;
  memory.known = known;
  memory.ground.setZero();
  memory.moment.setZero();
  const Vec<3> contact = ground.ContactArm(params.robot.foot_radius);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Vec<3> arm = dynamics.foot(leg).p_W + contact - dynamics.com_W;
    memory.ground += foot_forces[leg];
    memory.moment += arm.cross(foot_forces[leg]);
  }
  if (!before.started || before.force_source != gains.force_source) return memory.estimate;

  // Mean force and moment over the last interval.
  const Vec<3> change = (memory.linear - before.linear) / period;
  Vec<3> force = from_imu ? Vec<3>(mass * specific_force_W + change - before.ground)
                          : Vec<3>(change + weight - (before.ground + memory.ground) / 2);
  Vec<3> torque = (memory.angular - before.angular) / period - (before.moment + memory.moment) / 2;
  force -= before.known.force_W;
  torque -= before.known.torque_W;
  WrenchEstimate& estimate = memory.estimate;
  estimate.force_W += -std::expm1(-gains.force_bandwidth * period) * (force - estimate.force_W);
  estimate.torque_W += -std::expm1(-gains.torque_bandwidth * period) * (torque - estimate.torque_W);
  return estimate;
}

}  // namespace tenon
