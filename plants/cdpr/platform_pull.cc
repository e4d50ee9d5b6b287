#include <tenon/plants/cdpr/platform_pull.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {

void PlatformPullParams::Validate() const {
  Demand(std::isfinite(stiffness) && stiffness >= 0 && std::isfinite(damping) && damping >= 0 &&
             std::isfinite(max_force) && max_force >= 0,
         fmt::format("a pull of {} N/m, {} N s/m and {} N at most: none may be negative", stiffness, damping,
                     max_force));
}

Vec<3> PlatformPull::Force(const PlatformState& platform, const PlatformGrip& grip) const {
  if (!grip.on) return Vec<3>::Zero();
  const Eigen::Vector3d arm = platform.R_WB() * grip.p_B;
  const Eigen::Vector3d velocity = platform.v_W + platform.w_W.cross(arm);
  const Eigen::Vector3d force =
      params.stiffness * (grip.target_W - platform.p_WB - arm) - params.damping * velocity;
  const double size = force.norm();
  return size > params.max_force ? params.max_force / size * force : force;
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

TENON_DEFINE_SIGNAL(tenon::PlatformGrip);
