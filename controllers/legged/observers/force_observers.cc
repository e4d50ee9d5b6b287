#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/whole_body/foot_forces.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {

void ComObserverGains::Validate() const {
  force_bandwidth.CheckSize("force_bandwidth_rad_per_s", 3, "axes");
  torque_bandwidth.CheckSize("torque_bandwidth_rad_per_s", 3, "axes");
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
  for (int i = 0; i < 3; ++i) {
    estimate.force_W[i] += -std::expm1(-gains.force_bandwidth[i] * period) * (force[i] - estimate.force_W[i]);
    estimate.torque_W[i] +=
        -std::expm1(-gains.torque_bandwidth[i] * period) * (torque[i] - estimate.torque_W[i]);
  }
  return estimate;
}

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
  robot.CheckMass();
  gains.Validate();
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

void ContactThresholds::Validate() const {
  Demand(leave < touch,
         fmt::format("leave_weight_ratio = {} must be below touch_weight_ratio = {}, for hysteresis", leave,
                     touch));
}

void GroundForceObserverParams::Validate() const {
  robot.CheckMass();
  CheckGravity(gravity);
  Demand(std::isfinite(min_singular_value) && min_singular_value > 0,
         fmt::format("min_singular_value = {} m must be finite and positive, or a straight leg is singular",
                     min_singular_value));
}

FootForces GroundForceObserver::CalcForces(QuadrupedDynamics dynamics, const LegForceEstimate& leg_forces,
                                           const GroundPlane& ground, const ContactThresholds& thresholds,
                                           std::array<bool, kNumLegs>& stands) const {
  const Vec<3> arm = ground.ContactArm(params.robot.foot_radius), normal = ground.Normal();
  for (int leg = 0; leg < kNumLegs; ++leg) dynamics.feet[leg] = dynamics.Contact(leg, arm);
  FootForces forces = SolveFootForces(dynamics, leg_forces.joint_torque, params.min_singular_value);
  const double weight = model_.mass() * params.gravity;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    bool& stance = stands[leg];
    stance = forces[leg].dot(normal) > weight * (stance ? thresholds.leave : thresholds.touch);
    if (!stance) forces[leg].setZero();
  }
  return forces;
}

}  // namespace tenon
