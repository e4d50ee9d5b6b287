#include <tenon/controllers/guide_dog/supervisor.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenon {
namespace {

/// Accumulated time of a condition after one more tick: grows while it holds, decreases to 0 otherwise.
double Evidence(double before, bool is_so, double period) {
  return is_so ? before + period : std::max(0.0, before - period);
}

double HeadingError(double yaw, double heading) {
  return std::remainder(yaw - heading, 2 * std::numbers::pi);
}

}  // namespace

void SupervisorGains::Validate() const {
  Demand(release <= threshold,
         fmt::format("release_N = {} must be at most threshold_N = {}", release, threshold));
}

GuideMode NextGuideMode(GuideMode mode, const GuideEvents& events) {
  switch (mode) {
    case GuideMode::kMove:
      return events.pulled || events.obstacle ? GuideMode::kStop : mode;
    case GuideMode::kTurn:
      if (events.pulled || events.new_obstacle) return GuideMode::kStop;
      return events.aligned ? GuideMode::kMove : mode;
    case GuideMode::kStop:
      return events.pulled ? GuideMode::kTurn : mode;
  }
  return mode;
}

/// Updates the accumulated times by the force of one tick; returns true if a pull is detected.
bool Supervisor::FeelsPull(const Eigen::Vector2d& force_W, const SupervisorGains& gains,
                           GuideStatus* status) const {
  const double period = params.rate.period();
  const double force = force_W.norm();
  if (!status->released) {
    status->calm_time = Evidence(status->calm_time, force < gains.release, period);
    status->released = status->calm_time > gains.stop_time - period / 2;
    return false;
  }
  status->pull_time = Evidence(status->pull_time, force > gains.threshold, period);
  status->pull_W = status->pull_time > 0 ? Vec<2>(status->pull_W + force_W) : Vec<2>(0, 0);
  const double needed = status->mode == GuideMode::kStop ? gains.start_time : gains.stop_time;
  return status->pull_time > needed - period / 2 && status->since > gains.dwell - period / 2;
}

GuideStatus Supervisor::CalcStatus(const WrenchEstimate& wrench, const LeggedState& state,
                                   const bool& obstacle, const SupervisorGains& gains,
                                   GuideStatus& memory) const {
  GuideStatus next = memory;
  const Eigen::Matrix3d R = state.R_WB();
  const double heading = std::atan2(R(1, 0), R(0, 0));
  const double period = params.rate.period();
  next.since += period;
  next.unseen_time = obstacle ? 0 : memory.unseen_time + period;
  const bool forgotten = next.unseen_time > gains.dwell - period / 2;
  next.seen = !forgotten && (memory.seen || memory.mode == GuideMode::kStop);

  GuideEvents events;
  events.pulled = FeelsPull(wrench.force_W.head<2>(), gains, &next);
  events.obstacle = obstacle;
  events.new_obstacle = obstacle && !next.seen;
  const bool heads_there = std::abs(HeadingError(next.yaw, heading)) < gains.heading_tolerance;
  next.aligned_time =
      memory.mode == GuideMode::kTurn ? Evidence(memory.aligned_time, heads_there, period) : 0;
  events.aligned = next.aligned_time > gains.align_time - period / 2;
  next.mode = NextGuideMode(memory.mode, events);

  if (next.mode == GuideMode::kTurn && memory.mode == GuideMode::kStop)
    next.yaw = std::atan2(next.pull_W[1], next.pull_W[0]);
  if (events.pulled) {
    next.released = false;
    next.pull_time = next.calm_time = 0;
    next.pull_W.setZero();
  }
  if (next.mode != memory.mode) next.since = 0;
  next.yaw_rate = 0;
  if (next.mode == GuideMode::kTurn)
    next.yaw_rate =
        std::clamp(gains.turn_gain * HeadingError(next.yaw, heading), -gains.turn_rate, gains.turn_rate);
  return memory = next;
}

WalkCommand Supervisor::CalcWalk(const WalkCommand& command, const GuideStatus& status) const {
  if (status.mode == GuideMode::kStop || command.gait == Gait::kStand) {
    WalkCommand stand;
    stand.height = command.height;
    return stand;
  }
  WalkCommand walk = command;
  if (status.mode == GuideMode::kTurn) walk.yaw_rate = status.yaw_rate;
  return walk;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::GuideStatus);
