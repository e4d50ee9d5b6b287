#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/whole_body/foot_forces.h>

#include <fmt/core.h>

namespace tenon {
void ContactThresholds::Validate() const {
  Demand(leave < touch,
         fmt::format("leave_weight_ratio = {} must be below touch_weight_ratio = {}, for hysteresis", leave,
                     touch));
}

void GroundForceObserverParams::Validate() const {
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
  Demand(gravity > 0, fmt::format("gravity = {} m/s^2 must be positive", gravity));
  Demand(std::isfinite(min_singular_value) && min_singular_value > 0,
         fmt::format("min_singular_value = {} m must be finite and positive, or a straight leg is singular",
                     min_singular_value));
}

FootForces GroundForceObserver::CalcForces(QuadrupedDynamics dynamics, const LegForceEstimate& leg_forces,
                                           const GroundPlane& ground, const ContactThresholds& thresholds,
                                           std::array<bool, kNumLegs>& stands) const {
  const Vec<3> arm = ground.ContactArm(params.robot.foot_radius), normal = ground.Normal();
  for (int leg = 0; leg < kNumLegs; ++leg)
    dynamics.feet[static_cast<std::size_t>(leg)] = dynamics.Contact(leg, arm);
  FootForces forces = SolveFootForces(dynamics, leg_forces.joint_torque, params.min_singular_value);
  const double weight = model_.mass() * params.gravity;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    bool& stance = stands[static_cast<std::size_t>(leg)];
    stance = forces[leg].dot(normal) > weight * (stance ? thresholds.leave : thresholds.touch);
    if (!stance) forces[leg].setZero();
  }
  return forces;
}

}  // namespace tenon
