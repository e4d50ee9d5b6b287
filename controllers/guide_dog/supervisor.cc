#include <tenon/controllers/guide_dog/supervisor.h>

#include <fmt/core.h>

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

void Supervisor::EstimatePerson(const Eigen::Vector2d& force_W, const LeggedState& state,
                                const SupervisorGains& gains, Memory* memory) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  const double pull = -force_W.dot(heading), speed = state.v_W.head<2>().dot(heading);
  if (!memory->started) memory->tension = pull, memory->speed = speed;
  memory->started = true;
  const double period = params.rate.period();
  const double share = -std::expm1(-period / gains.speed_filter);
  const double change = share * (pull - memory->tension);
  memory->tension += change;
  memory->speed += share * (speed - memory->speed);
  memory->person_speed = memory->speed - change / period / gains.leash_stiffness;
}

/// Updates the accumulated times by the force of one tick, which only `counts` as a pull on a suitable
/// person; returns true if a pull is detected.
bool Supervisor::FeelsPull(const Eigen::Vector2d& force_W, bool counts, const SupervisorGains& gains,
                           GuideStatus* status) const {
  const double period = params.rate.period();
  const double force = force_W.norm();
  if (!status->released) {
    status->calm_time = Evidence(status->calm_time, force < gains.release, period);
    status->released = status->calm_time > gains.stop_time - period / 2;
    return false;
  }
  status->pull_time = Evidence(status->pull_time, counts && force > gains.threshold, period);
  status->pull_W = status->pull_time > 0 ? Vec<2>(status->pull_W + force_W) : Vec<2>(0, 0);
  const double needed = status->mode == GuideMode::kStop ? gains.start_time : gains.stop_time;
  return status->pull_time > needed - period / 2 && status->since > gains.dwell - period / 2;
}

Supervisor::Memory Supervisor::CalcProgress(const WrenchEstimate& wrench, const LeggedState& state,
                                            const bool& obstacle, const SupervisorGains& gains,
                                            Memory& memory) const {
  const GuideStatus last = memory.status;
  GuideStatus& next = memory.status;
  const Eigen::Matrix3d R = state.R_WB();
  const double heading = std::atan2(R(1, 0), R(0, 0));
  const double period = params.rate.period();
  next.since += period;
  next.unseen_time = obstacle ? 0 : last.unseen_time + period;
  const bool forgotten = next.unseen_time > gains.dwell - period / 2;
  next.seen = !forgotten && (last.seen || last.mode == GuideMode::kStop);

  GuideEvents events;
  const Eigen::Vector2d force_W = wrench.force_W.head<2>();
  bool counts = true;
  if (gains.leash_stiffness > 0) {
    EstimatePerson(force_W, state, gains, &memory);
    counts = last.mode == GuideMode::kStop || memory.person_speed < gains.stop_speed;
  }
  events.pulled = FeelsPull(force_W, counts, gains, &next);
  events.obstacle = obstacle;
  events.new_obstacle = obstacle && !next.seen;
  const bool heads_there = std::abs(HeadingError(next.yaw, heading)) < gains.heading_tolerance;
  next.aligned_time = last.mode == GuideMode::kTurn ? Evidence(last.aligned_time, heads_there, period) : 0;
  events.aligned = next.aligned_time > gains.align_time - period / 2;
  next.mode = NextGuideMode(last.mode, events);

  if (next.mode == GuideMode::kTurn && last.mode == GuideMode::kStop)
    next.yaw = std::atan2(next.pull_W[1], next.pull_W[0]);
  if (events.pulled) {
    next.released = false;
    next.pull_time = next.calm_time = 0;
    next.pull_W.setZero();
  }
  if (next.mode != last.mode) next.since = 0;
  next.yaw_rate = 0;
  if (next.mode == GuideMode::kTurn)
    next.yaw_rate =
        std::clamp(gains.turn_gain * HeadingError(next.yaw, heading), -gains.turn_rate, gains.turn_rate);
  return memory;
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
