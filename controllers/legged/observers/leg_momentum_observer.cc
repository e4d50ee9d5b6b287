#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/whole_body/foot_forces.h>

namespace tenon {

std::vector<double> LegObserverGains::Gains() const {
  if (butterworth) return ButterworthGains(butterworth->order, butterworth->bandwidth);
  return gains.empty() ? std::vector<double>{100, 256} : gains;
}

void LegObserverGains::Validate() const {
  Demand(gains.empty() || !butterworth,
         "gains_per_s and butterworth are both given, but exclude each other: set gains_per_s to [] or "
         "butterworth to null");
  DemandHurwitz(Gains());
}

void LegMomentumObserverParams::Validate() const {
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
  gains.Validate();
}

DisturbanceFilter LegMomentumObserver::CalcFilter(const LegObserverGains& gains) const {
  return {gains.Gains(), params.rate.period()};
}

LegForceEstimate LegMomentumObserver::CalcEstimate(const LeggedState& state,
                                                   const QuadrupedDynamics& dynamics,
                                                   const FootForces& foot_forces, const GroundPlane& ground,
                                                   const Vec<12>& held_torque, const LegObserverGains& gains,
                                                   const DisturbanceFilter& filter, Memory& memory) const {
  const bool exact = gains.dynamics == LegDynamics::kExact;
  DecoupledDynamics decoupled;
  if (!exact) model_.CalcDecoupled(state, dynamics, &decoupled);

  Vec<12> momentum, known_rate;
  if (exact) {
    momentum = dynamics.leg_momentum;
    known_rate = dynamics.leg_momentum_rate - dynamics.gravity.tail<12>() +
                 GroundTorque(dynamics, foot_forces, ground.ContactArm(params.robot.foot_radius));
  } else {
    momentum = decoupled.momentum;
    known_rate = decoupled.momentum_rate +
                 DecoupledGroundTorque(dynamics, foot_forces, ground.ContactArm(params.robot.foot_radius));
  }
  filter.Fit<12>(&memory.estimator);
  if (memory.started && memory.dynamics == gains.dynamics) {
    const Vec<12> mean = (momentum - memory.momentum) / params.rate.period() -
                         (known_rate + memory.known_rate) / 2 - held_torque;
    filter.Advance<12>(mean, &memory.estimator);
  }
  memory.started = true;
  memory.dynamics = gains.dynamics;
  memory.momentum = momentum;
  memory.known_rate = known_rate;

  LegForceEstimate estimate;
  estimate.joint_torque = DisturbanceFilter::Estimate<12>(memory.estimator);
  estimate.foot_force =
      exact ? SolveFootForces(dynamics, estimate.joint_torque, gains.min_singular_value)
            : SolveFootForces(dynamics, decoupled, estimate.joint_torque, gains.min_singular_value);
  return estimate;
}

}  // namespace tenon
