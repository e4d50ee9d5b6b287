#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/plants/signals/euler.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon {

WalkingErrors TrackingError::CalcErrors(const QuadrupedDynamics& dynamics, const FootForces& foot_forces,
                                        const ContactSchedule& schedule, const BodyReference& body,
                                        const FeetReference& feet, const WholeBodyPlan& plan) const {
  WalkingErrors errors;
  errors.com_position = dynamics.com_W;
  errors.com = dynamics.com_W - body.com_W;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    if (schedule.legs[i].state == ContactState::kSwing)
      errors.foot[leg] = (dynamics.feet[i].p_W - feet[leg].p_W).norm();
    else if (schedule.legs[i].stance())
      errors.ground_force[leg] = (plan.solution.force[leg] - foot_forces[leg]).norm();
  }
  return errors;
}

PathErrors TrackingError::CalcPath(const QuadrupedDynamics& dynamics, const LeggedState& state,
                                   const LeggedState& told, const ContactSchedule& schedule,
                                   const BodyReference& body, const FeetReference& feet) const {
  const auto heading = [](const LeggedState& x) { return EulerFromRotation(x.R_WB())[2]; };
  PathErrors errors;
  errors.drift = told.p_WB - state.p_WB;
  errors.yaw_drift = std::remainder(heading(told) - heading(state), 2 * std::numbers::pi);
  const Eigen::AngleAxisd turn(errors.yaw_drift, Vec<3>::UnitZ());
  const auto as_told = [&](const Vec<3>& x_W) -> Vec<3> { return told.p_WB + turn * (x_W - state.p_WB); };
  errors.com = as_told(dynamics.com_W) - body.com_W;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    if (schedule.legs[i].state == ContactState::kSwing)
      errors.foot[leg] = (as_told(dynamics.feet[i].p_W) - feet[leg].p_W).norm();
  }
  return errors;
}

FootForces TrackingError::CalcExternalFootForces(const QuadrupedDynamics& dynamics,
                                                 const Vec<12>& external_torque,
                                                 double min_singular_value) const {
  return SolveFootForces(dynamics, external_torque, min_singular_value);
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::WalkingErrors);
TENON_DEFINE_SIGNAL(tenon::PathErrors);
