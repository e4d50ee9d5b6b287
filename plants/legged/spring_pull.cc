#include <tenon/plants/legged/spring_pull.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

/// Axes, origin and motion of a body in W.
struct Frame {
  Eigen::Matrix3d R;
  Eigen::Vector3d p, v, w;
};

Frame FrameOf(const QuadrupedDescription& robot, const LeggedState& x, int body) {
  Frame frame{x.R_WB(), x.p_WB, x.v_W, x.w_W};
  if (body == 0) return frame;
  const int last = body - 1;
  for (int j = last - last % kJointsPerLeg; j <= last; ++j) {
    const JointDescription& joint = robot.joint(j);
    const Eigen::Vector3d arm = frame.R * joint.p_PJ;
    frame.v += frame.w.cross(arm);
    frame.p += arm;
    frame.R = frame.R * Eigen::AngleAxisd(x.q[j], joint.axis);
    frame.w += x.qd[j] * (frame.R * joint.axis);
  }
  return frame;
}

}  // namespace

BodyPoint PointOfBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_B) {
  const Frame frame = FrameOf(robot, x, body);
  const Eigen::Vector3d arm = frame.R * p_B;
  return {frame.p + arm, frame.v + frame.w.cross(arm)};
}

Vec<3> PointInBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_W) {
  const Frame frame = FrameOf(robot, x, body);
  return frame.R.transpose() * (p_W - frame.p);
}

void SpringPullParams::Validate() const {
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
  Demand(std::isfinite(stiffness) && stiffness >= 0 && std::isfinite(damping) && damping >= 0 &&
             std::isfinite(max_force) && max_force >= 0,
         fmt::format("stiffness = {} N/m, damping = {} N s/m and max_force = {} N must not be negative",
                     stiffness, damping, max_force));
}

SpringPullParams SpringPull::Complete(SpringPullParams params) {
  const double mass = params.robot.mass(), weight = kGravity * mass;
  if (params.stiffness == 0) params.stiffness = 0.5 * weight / 0.25;
  if (params.damping == 0) params.damping = 0.2 * 2 * std::sqrt(params.stiffness * mass);
  if (params.max_force == 0) params.max_force = weight;
  return params;
}

ExternalForce SpringPull::CalcForce(const LeggedState& state, const SpringGrip& grip) const {
  ExternalForce force;
  if (!grip.on) return force;
  if (grip.body < 0 || grip.body > kNumJoints)
    throw RunError(fmt::format(
        "a spring pull acts on body {}: give 0 for the trunk or 1 to {} for the body that a joint "
        "moves",
        grip.body, kNumJoints));
  const BodyPoint point = PointOfBody(params.robot, state, grip.body, grip.p_B);
  force.body = grip.body;
  force.p_B = grip.p_B;
  force.force_W = params.stiffness * (grip.target_W - point.p_W) - params.damping * point.v_W;
  const double size = force.force_W.norm();
  if (size > params.max_force) force.force_W *= params.max_force / size;
  return force;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::SpringGrip);
