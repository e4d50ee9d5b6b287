#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon {

PlatformWrench Gusts::CalcWrench(double time) const {
  PlatformWrench wrench;
  for (const Gust& gust : params.gusts) {
    const double phase = (time - gust.start) / gust.duration;
    if (phase >= 0 && phase < 1)
      wrench.force_W += (1 - std::cos(2 * std::numbers::pi * phase)) / 2 * gust.force_W;
  }
  return wrench;
}

PlatformWrench HangingLoad::CalcWrench(const Rope& rope, const PlatformWrench& others) const {
  return {others.force_W + rope.force_W, others.torque_W + rope.arm_W.cross(rope.force_W)};
}

Geometry HangingLoad::MakeGeometry() {
  return {Shape::Sphere(ShapeRole::kLoad, "hanging load", 0.05),
          Shape::Segment(ShapeRole::kLine, "rope", 0.008, "N")};
}

HangingLoad::Rope HangingLoad::CalcRope(const PlatformState& platform, const HangingLoadState& state) const {
  Rope rope;
  rope.arm_W = platform.R_WB() * params.attachment_B;
  const Vec<3> span = state.p_W - platform.p_WB - rope.arm_W;
  const double length = span.norm();
  if (length <= params.length) return rope;
  const Vec<3> direction = span / length;
  const double rate = direction.dot(state.v_W - platform.v_W - platform.w_W.cross(rope.arm_W));
  const double tension =
      (params.axial_stiffness * (length - params.length) + params.axial_damping * rate) / params.length;
  rope.force_W = std::max(0.0, tension) * direction;
  return rope;
}

void HangingLoad::CalcGeometry(const PlatformState& platform, const HangingLoadState& state, const Rope& rope,
                               Geometry* out) const {
  Shape &ball = (*out)[0], &line = (*out)[1];
  ball.p_W = state.p_W;
  line.p_W = platform.p_WB + rope.arm_W;
  line.vector_W = state.p_W - line.p_W;
  line.value = rope.force_W.norm();
}

void PayloadScheduleParams::Validate() const {
  Demand(release_s >= attach_s,
         fmt::format("release_s = {} must not be before attach_s = {}", release_s, attach_s));
}

Vec<3> PlatformPull::Force(const PlatformState& platform, const PlatformGrip& grip) const {
  if (!grip.on) return Vec<3>::Zero();
  const Eigen::Vector3d arm = platform.R_WB() * grip.p_B;
  const Eigen::Vector3d velocity = platform.v_W + platform.w_W.cross(arm);
  return Shortened<3>(params.stiffness * (grip.target_W - platform.p_WB - arm) - params.damping * velocity,
                      params.max_force);
}

PlatformWrench PlatformPull::CalcWrench(const PlatformState& platform, const PlatformWrench& others,
                                        const PlatformGrip& grip) const {
  PlatformWrench wrench = others;
  if (!grip.on) return wrench;
  const Vec<3> force = Force(platform, grip);
  wrench.force_W += force;
  wrench.torque_W += (platform.R_WB() * grip.p_B).cross(force);
  return wrench;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::HangingLoadState);
TENON_DEFINE_SIGNAL(tenon::PlatformGrip);
