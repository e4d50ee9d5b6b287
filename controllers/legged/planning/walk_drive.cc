#include <tenon/controllers/legged/planning/walk_drive.h>

#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kSameHeight = 1e-6;  // tolerance of the height when returning to the plan [m], [m/s]

}  // namespace

void WalkDriveParams::Validate() const {
  Demand(gait != Gait::kStand, "gait is `stand`, which does not move: set `stands` instead");
  Demand(acceleration > 0, fmt::format("acceleration_m_per_s2 = {} must be positive", acceleration));
  Demand(yaw_acceleration > 0,
         fmt::format("yaw_acceleration_rad_per_s2 = {} must be positive", yaw_acceleration));
  Demand(height_bandwidth > 0 && height_bandwidth * rate.period() < 0.5,
         fmt::format("height_bandwidth_rad_per_s = {} must be positive, and below {} rad/s at this rate",
                     height_bandwidth, 0.5 / rate.period()));
}

WalkCommand WalkDrive::CalcCommand(const WalkCommand& planned, const VelocityCommand& request, bool active,
                                   const Vec<3>& velocity, Gait gait, bool stands, double height,
                                   DriveProgress& progress) const {
  active = active || request.active;
  stands = stands && !request.active;
  if (active != progress.active) {
    const double sign = active ? 1 : -1;
    progress.active = active;
    progress.velocity += sign * Vec<3>(planned.forward, planned.left, planned.yaw_rate);
    progress.height += sign * planned.height[0];
    progress.height_rate += sign * planned.height[1];
  }
  const double dt = params.rate.period();
  const Vec<3>& asked = request.active ? request.velocity : velocity;
  const Vec<3> ordered = active && !stands ? asked : Vec<3>(Vec<3>::Zero());
  Eigen::Vector2d change = (ordered - progress.velocity).head<2>();
  if (change.norm() > params.acceleration * dt) change *= params.acceleration * dt / change.norm();
  progress.velocity.head<2>() += change;
  const double turn = params.yaw_acceleration * dt;
  progress.velocity[2] += std::clamp(ordered[2] - progress.velocity[2], -turn, turn);
  const bool moves = !progress.velocity.isZero(0);

  const double w = params.height_bandwidth;
  const double acceleration =
      w * w * ((active ? height : 0) - progress.height) - 2 * w * progress.height_rate;
  WalkCommand command;
  if (!active) {
    command = planned;
    if (moves && command.gait == Gait::kStand) command.gait = gait;  // keeps walking until it has slowed down
  } else {
    command.gait = stands && !moves ? Gait::kStand : gait;
  }
  command.forward += progress.velocity[0];
  command.left += progress.velocity[1];
  command.yaw_rate += progress.velocity[2];
  command.height += Vec<3>(progress.height, progress.height_rate, acceleration);
  progress.height += dt * progress.height_rate;
  progress.height_rate += dt * acceleration;
  if (!active && std::abs(progress.height) < kSameHeight && std::abs(progress.height_rate) < kSameHeight)
    progress.height = progress.height_rate = 0;
  return command;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::DriveProgress);
