#include <tenon/plants/legged/disturbances.h>
#include <tenon/plants/legged/ropes.h>
#include <tenon/plants/legged/sliding_load.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/format.h>

#include <numbers>

namespace tenon {
namespace {

void CheckForce(const ExternalForce& force) {
  Demand(
      force.body >= 0 && force.body <= kNumJoints,
      fmt::format("body {} does not exist; give 0 for the trunk or 1 to {} for the body that a joint moves",
                  force.body, kNumJoints));
  Demand(internal::IsFinite(force), "point, force and torque must be finite: give m, N and N m");
}

}  // namespace

ExternalForce PointOnLeg(const QuadrupedDescription& robot, int leg, double height) {
  Demand(leg >= 0 && leg < kNumLegs, fmt::format("leg {} does not exist; give 0 to {}", leg, kNumLegs - 1));
  Demand(height >= 0 && height <= 1,
         fmt::format("height {} is not on the leg; give 0 for the foot to 1 for the hip", height));
  const LegDescription& at = robot.legs[leg];
  const int shank = kJointsPerLeg * (leg + 1);
  ExternalForce force;
  if (height <= 0.5) {
    force.body = shank;
    force.p_B = (1 - 2 * height) * at.foot_J;
  } else {
    force.body = shank - 1;
    force.p_B = (2 - 2 * height) * at.joints[2].p_PJ;
  }
  return force;
}

void SineForceParams::Validate() const {
  CheckForce(amplitude);
  Demand(end >= start,
         fmt::format("the force ends at {} s, before its start at {} s: exchange them", end, start));
}

ExternalForce SineForce::CalcForce(double time, const ExternalForce& amplitude, double angular_frequency,
                                   double start, double end) const {
  ExternalForce force = amplitude;
  const bool on = time >= start && time < end;
  const double wave = on ? std::sin(angular_frequency * (time - start)) : 0;
  force.force_W *= wave;
  force.torque_W *= wave;
  return force;
}

void PulseForceParams::Validate() const {
  CheckForce(push);
}

ExternalForce PulseForce::CalcForce(double time, const ExternalForce& push, double start,
                                    double duration) const {
  // Tolerates the rounding of start + duration; ticks are exact multiples of the period.
  const double rounding = 1e-6 * params.rate.period();
  const double since = time - start + rounding;
  return since >= 0 && since < duration ? push : ExternalForce{};
}

void RandomForceParams::Validate() const {
  robot.CheckMass();
  Demand(upper >= lower,
         fmt::format("the bounds of the magnitude are {} and {} N: give lower <= upper", lower, upper));
}

ExternalForce RandomForce::CalcForce(bool on_trunk, double lower, double upper, RandomStream& random) const {
  // Draws equally many numbers for the trunk and for a leg, so that on_trunk does not change the sequence.
  const int leg = static_cast<int>(random.Uniform(0, kNumLegs));
  const double height = random.Uniform();
  const double magnitude = random.Uniform(lower, upper);
  const double z = random.Uniform(-1, 1), angle = random.Uniform(0, 2 * std::numbers::pi);
  ExternalForce force;
  if (!on_trunk) force = PointOnLeg(params.robot, leg, height);
  const double r = std::sqrt(1 - z * z);
  force.force_W = magnitude * Vec<3>(r * std::cos(angle), r * std::sin(angle), z);
  return force;
}

void ForceBundleParams::Validate() const {
  Demand(count <= kMaxExternalForces,
         fmt::format("{} forces are too many: a robot takes at most {}", count, kMaxExternalForces));
}

ExternalForces ForceBundle::CalcForces(const Inputs<ExternalForce>& force) const {
  ExternalForces forces;
  for (std::size_t i = 0; i < force.size(); ++i) forces[i] = force[i];
  return forces;
}

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
  robot.CheckMass();
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
  force.force_W = Shortened<3>(params.stiffness * (grip.target_W - point.p_W) - params.damping * point.v_W,
                               params.max_force);
  return force;
}

namespace {

constexpr double kDrawnEdge = 0.12;  // [m]
constexpr double kFollow = 50;       // rate at which a load without mass follows position_B [1/s]

}  // namespace

/// Motion of a point fixed to the trunk.
static LoadMotion OnTrunk(const LeggedState& robot, const Vec<3>& p_B) {
  const Eigen::Vector3d arm = robot.R_WB() * p_B;
  return {robot.p_WB + arm, robot.v_W + robot.w_W.cross(arm)};
}

LoadMotion SlidingLoad::Start(const SlidingLoadParams& params) {
  return OnTrunk(params.robot, params.position_B);
}

ExternalForce SlidingLoad::CalcForce(const LeggedState& robot, const LoadMotion& motion, const Vec<3>& place,
                                     double mass, double friction, double slip_speed) const {
  ExternalForce force;
  if (mass == 0) return force;
  const double k = params.stiffness, d = 2 * params.damping_ratio * std::sqrt(k * mass);
  const Eigen::Matrix3d R_WB = robot.R_WB();
  const Eigen::Vector3d velocity =
      R_WB.transpose() * (motion.v_W - robot.v_W - robot.w_W.cross(motion.p_W - robot.p_WB));
  const Eigen::Vector3d away = place - params.position_B;

  Eigen::Vector3d on_load;
  on_load[2] = std::max(0.0, mass * params.gravity - k * away[2] - d * velocity[2]);
  const Eigen::Vector2d slip = velocity.head<2>();
  on_load.head<2>() = -friction * on_load[2] / std::hypot(slip.norm(), slip_speed) * slip;
  for (int axis = 0; axis < 2; ++axis) {
    const double side = away[axis] < 0 ? -1 : 1;
    const double beyond = side * away[axis] - params.reach[axis];
    if (beyond > 0) on_load[axis] -= side * std::max(0.0, k * beyond + d * side * velocity[axis]);
  }

  force.p_B = place;
  force.force_W = -(R_WB * on_load);
  return force;
}

LoadMotion SlidingLoad::CalcDerivative(const LeggedState& robot, const LoadMotion& motion,
                                       const ExternalForce& force, double mass) const {
  if (mass == 0) {
    const LoadMotion place = OnTrunk(robot, params.position_B);
    return {place.v_W + kFollow * (place.p_W - motion.p_W), kFollow * (place.v_W - motion.v_W)};
  }
  return {motion.v_W, Vec<3>(0, 0, -params.gravity) - force.force_W / mass};
}

Geometry SlidingLoad::MakeGeometry() {
  return {Shape::Box(ShapeRole::kLoad, "sliding load", Vec<3>::Constant(kDrawnEdge))};
}

void SlidingLoad::CalcGeometry(const LeggedState& robot, const LoadMotion& motion, double mass,
                               Geometry* geometry) const {
  (*geometry)[0].visible = mass > 0;
  (*geometry)[0].p_W = motion.p_W;
  (*geometry)[0].q_W = robot.q_WB;
}

void Ropes::CalcTension(const CableVector& command, CableVector* tension) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), command.size(), "Ropes");
  for (std::size_t i = 0; i < params.ropes.size(); ++i)
    (*tension)[i] = std::clamp(command[i], 0.0, params.ropes[i].tension_max);
}

ExternalForce Ropes::CalcForce(const LeggedState& robot, const CableVector& tension) const {
  ExternalForce sum;
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], robot);
    const Vec<3> pull = tension[i] * line.direction_W;
    sum.force_W += pull;
    sum.torque_W += line.arm_W.cross(pull);
  }
  return sum;
}

Geometry Ropes::MakeGeometry() const {
  constexpr double kDrawnRadius = 0.006;  // [m]
  Geometry lines;
  for (const Rope& rope : params.ropes)
    lines.push_back(Shape::Segment(ShapeRole::kLine, rope.name, kDrawnRadius, "N"));
  return lines;
}

void Ropes::CalcGeometry(const LeggedState& robot, const CableVector& tension, Geometry* geometry) const {
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], robot);
    Shape& shape = (*geometry)[i];
    shape.p_W = robot.p_WB + line.arm_W;
    shape.vector_W = line.length * line.direction_W;
    shape.value = tension[i];
  }
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::SpringGrip);
TENON_DEFINE_SIGNAL(tenon::LoadMotion);
