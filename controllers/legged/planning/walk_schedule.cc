#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon {
namespace {

double Speed(const WalkCommand& c) {
  return std::hypot(c.forward, c.left);
}

WalkCommand Between(const WalkCommand& from, const WalkCommand& to, double s) {
  return {to.gait, from.forward + s * (to.forward - from.forward), from.left + s * (to.left - from.left),
          from.yaw_rate + s * (to.yaw_rate - from.yaw_rate), Vec<3>::Zero()};
}

/// Height, velocity and acceleration at time t of squats that end at `end`.
Vec<3> Squat(double amplitude, double w, double t, double end) {
  const double period = 2 * std::numbers::pi / w;
  MotionPoint size{1, 0, 0};
  if (t < period) size = Quintic({}, {1, 0, 0}, period, t);
  if (end - t < period) size = Quintic({1, 0, 0}, {}, period, t - (end - period));
  const Vec<3> wave(std::sin(w * t), w * std::cos(w * t), -w * w * std::sin(w * t));
  return amplitude *
         Vec<3>(size.position * wave[0], size.velocity * wave[0] + size.position * wave[1],
                size.acceleration * wave[0] + 2 * size.velocity * wave[1] + size.position * wave[2]);
}

}  // namespace

void WalkScheduleParams::Validate() const {
  Demand(!segments.empty(), "segments is empty: give at least one");
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const WalkSegment& s = segments[i];
    Demand(s.duration.has_value() != s.length.has_value(),
           fmt::format("segments.{} needs either duration_s or length_m, not {}", i,
                       s.duration ? "both" : "neither"));
    Demand(s.gait != Gait::kStand || (s.forward == 0 && s.left == 0 && s.yaw_rate == 0),
           fmt::format("segments.{} moves while it stands: give it another gait", i));
    Demand(!s.length || s.forward != 0 || s.left != 0,
           fmt::format("segments.{} has a length but no speed: give its duration_s", i));
  }
}

std::vector<WalkSchedule::Piece> WalkSchedule::MakePieces(const WalkScheduleParams& params) {
  std::vector<Piece> pieces;
  double begin = 0;
  WalkCommand from;
  for (std::size_t i = 0; i < params.segments.size(); ++i) {
    const WalkSegment& s = params.segments[i];
    const WalkCommand to{s.gait, s.forward, s.left, s.yaw_rate, Vec<3>::Zero()};
    const bool stands = s.gait == Gait::kStand;
    if (stands) from = to;
    const double change = std::hypot(to.forward - from.forward, to.left - from.left);
    const double ramp = std::max(change / params.acceleration,
                                 std::abs(to.yaw_rate - from.yaw_rate) / params.yaw_acceleration);
    // Length of the ramp by Simpson's rule, exact while the direction is constant.
    const double way = ramp / 6 * (Speed(from) + 4 * Speed(Between(from, to, 0.5)) + Speed(to));
    const double duration = s.duration ? *s.duration : ramp + (*s.length - way) / Speed(to);
    Demand(duration >= ramp,
           fmt::format("segments.{} is too short to reach its velocities, which takes {:.3g} s and "
                       "{:.3g} m: make it longer or the accelerations larger",
                       i, ramp, way));
    Demand(
        s.squat_amplitude == 0 || duration * s.squat_frequency >= 2,
        fmt::format("segments.{} is too short for its squats: two take {:.3g} s", i, 2 / s.squat_frequency));
    pieces.push_back({begin, ramp, begin + duration, from, to, s.squat_amplitude,
                      2 * std::numbers::pi * s.squat_frequency});
    begin += duration;
    from = to;
  }
  return pieces;
}

WalkSchedule::Extent WalkSchedule::extent() const {
  Extent extent;
  // Simpson's rule, exact on a ramp with a constant direction.
  const auto add = [&](double duration, const WalkCommand& from, const WalkCommand& to) {
    const WalkCommand middle = Between(from, to, 0.5);
    extent.length += duration / 6 * (Speed(from) + 4 * Speed(middle) + Speed(to));
    extent.turn +=
        duration / 6 * (std::abs(from.yaw_rate) + 4 * std::abs(middle.yaw_rate) + std::abs(to.yaw_rate));
  };
  for (const Piece& piece : pieces_) {
    add(piece.ramp, piece.from, piece.to);
    add(piece.end - piece.begin - piece.ramp, piece.to, piece.to);
  }
  return extent;
}

WalkCommand WalkSchedule::CalcCommand(const double& time) const {
  for (const Piece& piece : pieces_) {
    if (time >= piece.end) continue;
    const double t = time - piece.begin;
    WalkCommand command = t < piece.ramp ? Between(piece.from, piece.to, t / piece.ramp) : piece.to;
    if (piece.amplitude != 0)
      command.height = Squat(piece.amplitude, piece.frequency, t, piece.end - piece.begin);
    return command;
  }
  return {};
}

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
  const Eigen::Vector2d change = (ordered - progress.velocity).head<2>();
  progress.velocity.head<2>() += Shortened<2>(change, params.acceleration * dt);
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
