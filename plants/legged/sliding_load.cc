#include <tenon/plants/legged/sliding_load.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kDrawnEdge = 0.12;  // [m]
constexpr double kFollow = 50;       // rate at which a load without mass follows position_B [1/s]

void DemandPositive(const char* name, double value, const char* unit) {
  Demand(std::isfinite(value) && value > 0,
         fmt::format("the sliding load's {} of {}{} must be positive", name, value, unit));
}

}  // namespace

void SlidingLoadParams::Validate() const {
  DemandPositive("stiffness", stiffness, " N/m");
  DemandPositive("gravity", gravity, " m/s^2");
  Demand(std::isfinite(damping_ratio) && damping_ratio >= 0,
         fmt::format("the sliding load's damping_ratio of {} must not be negative", damping_ratio));
  Demand(position_B.allFinite(), "the sliding load's position_B must be finite: give metres");
}

/// Motion of a point fixed to the trunk.
static LoadMotion OnTrunk(const LeggedState& robot, const Vec<3>& p_B) {
  const Eigen::Vector3d arm = robot.R_WB() * p_B;
  return {robot.p_WB + arm, robot.v_W + robot.w_W.cross(arm)};
}

LoadMotion SlidingLoad::Start(const SlidingLoadParams& params) {
  return OnTrunk(params.robot, params.position_B);
}

Vec<3> SlidingLoad::CalcPlace(const LeggedState& robot, const LoadMotion& motion) const {
  return robot.R_WB().transpose() * (motion.p_W - robot.p_WB);
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

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::LoadMotion);
