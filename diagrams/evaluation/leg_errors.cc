#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/diagrams/evaluation/leg_errors.h>

#include <Eigen/Geometry>

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

void LegErrors::CalcGeometry(const Points& footholds, Geometry* geometry) const {
  for (std::size_t i = 0; i < kNumLegs; ++i) (*geometry)[i].p_W = footholds[i];
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::ForcesAtPoints);
