#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/diagrams/evaluation/leg_errors.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/plants/signals/euler.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon {
namespace {

/// Columns, of the leg's joints, of the Jacobian in W of a point of one of the leg's bodies.
Eigen::Matrix3d JacobianOf(const LegDescription& leg, const LegPose& pose, const Eigen::Matrix3d& R_WB,
                           std::size_t body, const Vec<3>& p_J) {
  const Eigen::Vector3d p_B = pose.p_BJ[body] + pose.R_BJ[body] * p_J;
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i <= body; ++i)
    J.col(static_cast<Eigen::Index>(i)) =
        R_WB * (pose.R_BJ[i] * leg.joints[i].axis).cross(p_B - pose.p_BJ[i]);
  return J;
}

}  // namespace

Vec<4> LegErrors::CalcFoot(const LeggedState& state, const ContactSchedule& schedule,
                           const FeetReference& feet, const Points& footholds, Memory& memory) const {
  Vec<4> errors = Vec<4>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const bool swings = schedule.legs[i].state == ContactState::kSwing;
    if (swings) memory.foothold[i] = footholds[i].isZero(0) ? feet[leg].p_W : footholds[i];
    memory.swung[i] = memory.swung[i] || swings;
    if (!memory.swung[i]) continue;
    const Vec<3> p_W = state.p_WB + state.R_WB() * params.robot.FootPosition(leg, state.q);
    errors[leg] = (p_W - (swings ? feet[leg].p_W : memory.foothold[i])).norm();
  }
  return errors;
}

ForcesAtPoints LegErrors::CalcForces(const LeggedState& state, const ExternalForces& external,
                                     const Vec<12>& external_torque,
                                     const LegForceEstimate& leg_forces) const {
  ForcesAtPoints at;
  const Eigen::Matrix3d R_WB = state.R_WB();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const LegDescription& description = params.robot.legs[i];
    std::size_t body = kJointsPerLeg - 1;
    Vec<3> p_J = description.foot_J;
    for (const ExternalForce& force : external) {
      const int joint = force.body - 1 - kJointsPerLeg * leg;
      if (joint < 0 || joint >= kJointsPerLeg || force.force_W.isZero(0)) continue;
      body = static_cast<std::size_t>(joint);
      p_J = force.p_B;
      break;
    }
    const Eigen::Matrix3d J = JacobianOf(description, params.robot.PoseOfLeg(leg, state.q), R_WB, body, p_J);
    const auto solve = [&](const Vec<12>& torque) {
      return SolveForce(J, torque.segment<3>(kJointsPerLeg * leg), params.min_singular_value);
    };
    at.force[leg] = solve(external_torque);
    at.estimate[leg] = solve(leg_forces.joint_torque);
    at.error[leg] = (at.estimate[leg] - at.force[leg]).norm();
  }
  return at;
}

Geometry LegErrors::MakeShapes(const QuadrupedDescription& robot) {
  Geometry shapes;
  for (const char* leg : kLegNames)
    shapes.push_back(Shape::Sphere(ShapeRole::kReference, "planned foothold of " + std::string(leg),
                                   1.2 * robot.foot_radius));
  return shapes;
}

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

Geometry WalkView::MakeShapes(const QuadrupedDescription& robot) {
  const double scale =
      2 * robot.StanceHeight() / (kGravity * robot.mass());  // the weight is twice the robot's height
  Geometry shapes{Shape::Trace(ShapeRole::kReference, "reference of the CoM"),
                  Shape::Arrow(ShapeRole::kEstimate, "estimated force on the CoM", scale)};
  for (const char* leg : kLegNames)
    shapes.push_back(Shape::Arrow(ShapeRole::kEstimate, "estimated force on " + std::string(leg), scale));
  return shapes;
}

void WalkView::CalcGeometry(const LeggedState& state, const BodyReference& body, const WrenchEstimate& wrench,
                            const LegForceEstimate& leg_forces, Geometry* geometry) const {
  Geometry& shapes = *geometry;
  shapes[0].p_W = body.com_W;
  shapes[1].p_W = body.com_W;
  shapes[1].vector_W = wrench.force_W;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    Shape& arrow = shapes[2 + static_cast<std::size_t>(leg)];
    arrow.p_W = state.p_WB + state.R_WB() * params.robot.FootPosition(leg, state.q);
    arrow.vector_W = leg_forces.foot_force[leg];
  }
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::ForcesAtPoints);
TENON_DEFINE_SIGNAL(tenon::WalkingErrors);
TENON_DEFINE_SIGNAL(tenon::PathErrors);
