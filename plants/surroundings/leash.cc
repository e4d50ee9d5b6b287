#include <tenon/plants/surroundings/leash.h>

#include <Eigen/Geometry>

namespace tenon {
namespace {

constexpr double kDrawnRadius = 0.01;  // [m]

}  // namespace

LeashState Leash::CalcLeash(const LeggedState& robot, const PersonState& person, double nominal_length,
                            double stiffness, double dissipation) const {
  const Eigen::Vector3d arm = robot.R_WB() * params.attachment_B;
  const Eigen::Vector3d along = robot.p_WB + arm - person.hand_W;
  LeashState leash;
  leash.length = along.norm();
  if (leash.length > 0) leash.direction_W = along / leash.length;
  const double elongation = leash.length - nominal_length;
  const double rate = leash.direction_W.dot(robot.v_W + robot.w_W.cross(arm) - person.v_W);
  if (params.handle)
    leash.tension = stiffness * (elongation + params.damping_time * rate);
  else if (elongation > 0)
    leash.tension = stiffness * elongation * std::max(0.0, 1 + dissipation * rate);
  return leash;
}

ExternalForce Leash::CalcForce(const LeashState& leash) const {
  ExternalForce force;
  force.p_B = params.attachment_B;
  force.force_W = -leash.tension * leash.direction_W;
  return force;
}

Geometry Leash::MakeGeometry() {
  return {Shape::Segment(ShapeRole::kLine, "leash", kDrawnRadius, "N")};
}

void Leash::CalcGeometry(const PersonState& person, const LeashState& leash, Geometry* geometry) const {
  Shape& rod = (*geometry)[0];
  rod.p_W = person.hand_W;
  rod.vector_W = leash.length * leash.direction_W;
  rod.value = leash.tension;
}

}  // namespace tenon
