#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/controllers/guide_dog/supervisor.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <Eigen/Geometry>
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

void AdmittanceGains::Validate() const {
  Demand(max_forward > min_forward,
         fmt::format("max_forward_m_per_s = {} must be above min_forward_m_per_s = {}", max_forward,
                     min_forward));
  Demand(yield_tension == 0 || yield_tension > desired_tension,
         fmt::format("yield_tension_N = {} must be 0 or above desired_tension_N = {}", yield_tension,
                     desired_tension));
  mass.CheckSize("mass_kg", 2, "axes");
  damping.CheckSize("damping_N_s_per_m", 2, "axes");
}

AdmittanceFilter::Steps AdmittanceFilter::CalcSteps(const AdmittanceGains& gains) const {
  const auto step = [&](int axis, double stiffness) -> Eigen::Matrix3d {
    const double mass = gains.mass[axis], damping = gains.damping[axis];
    Eigen::Matrix3d rates;
    rates << 0, 1, 0,                                  //
        -stiffness / mass, -damping / mass, 1 / mass,  //
        0, 0, 0;
    return Exponential(params.rate.period() * rates);
  };
  return {step(0, 0), step(1, gains.stiffness)};
}

AdmittanceFilter::Memory AdmittanceFilter::CalcProgress(const WalkCommand& command,
                                                        const WrenchEstimate& wrench,
                                                        const LeggedState& state,
                                                        const AdmittanceGains& gains, const Steps& steps,
                                                        Memory& memory) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  const Eigen::Vector2d to_left(-heading[1], heading[0]);
  const Eigen::Vector2d force_W = wrench.force_W.head<2>();
  const Eigen::Vector2d force(heading.dot(force_W), to_left.dot(force_W));
  const Eigen::Vector2d ahead(gains.desired_tension, 0);

  AdmittanceMotion next;
  next.direction = ahead == force ? Eigen::Vector2d(1, 0) : (ahead - force).normalized();
  next.tension = -force.dot(next.direction);
  const double period = params.rate.period();
  const bool commanded = command.gait != Gait::kStand;
  if (commanded) memory.gait = command.gait;
  const double bearable =
      memory.yields ? (gains.desired_tension + gains.yield_tension) / 2 : gains.yield_tension;
  const bool pulled = memory.gait != Gait::kStand && gains.yield_tension > 0 && force.norm() > bearable;
  memory.pull_time = std::min(Evidence(memory.pull_time, pulled, period), gains.yield_time);
  const bool lasts = memory.yields ? pulled || memory.pull_time > 0
                                   : pulled && memory.pull_time > gains.yield_time - period / 2;
  memory.yields = !commanded && lasts;
  if (!commanded) memory.adaptation = 0;
  next.walks = commanded || memory.yields;
  if (!next.walks) {
    memory.motion = next;
    return memory;
  }

  const AdmittanceMotion& last = memory.motion;
  const Eigen::Vector2d drive = (gains.desired_tension - next.tension) * next.direction;
  const Eigen::Vector2d asked =
      commanded ? Eigen::Vector2d(command.forward, command.left) : Eigen::Vector2d(0, 0);
  const Eigen::Vector2d nominal = asked + Eigen::Vector2d(memory.adaptation, 0);
  const Eigen::Vector3d along = steps.along * Eigen::Vector3d(0, last.correction[0], drive[0]);
  const Eigen::Vector3d across = steps.across * Eigen::Vector3d(last.offset, last.correction[1], drive[1]);
  const Eigen::Vector2d wanted = nominal + Eigen::Vector2d(along[1], across[1]);

  const Eigen::Vector2d lowest(commanded ? gains.min_forward : -gains.max_backward, -gains.max_left);
  const Eigen::Vector2d highest(commanded ? gains.max_forward : 0, gains.max_left);
  const Eigen::Array2d change = Eigen::Array2d::Constant(gains.acceleration * period);
  const Eigen::Array2d inside =
      wanted.array().max(lowest.cwiseMin(asked).array()).min(highest.cwiseMax(asked).array());
  next.velocity = inside.max(last.velocity.array() - change).min(last.velocity.array() + change);
  next.correction = next.velocity - nominal;
  next.offset = next.velocity[1] == wanted[1] ? across[0] : last.offset + period * next.correction[1];
  if (commanded && next.velocity[0] == wanted[0])
    memory.adaptation += period * gains.adaptation_rate * drive[0] / gains.damping[0];
  memory.motion = next;
  return memory;
}

WalkCommand AdmittanceFilter::CalcWalk(const WalkCommand& command, const Memory& progress) const {
  WalkCommand walk = command;
  if (progress.yields) walk.gait = progress.gait;
  walk.forward = progress.motion.velocity[0];
  walk.left = progress.motion.velocity[1];
  return walk;
}

namespace {

Eigen::Matrix3d HeadingOf(const BodyReference& body) {
  const double yaw = EulerFromRotation(RotationFromQuaternion(body.q_WB))[2];
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

Vec<6> ReferenceAdmittance::CalcRate(const Vec<6>& x, const BodyReference& body, const WrenchEstimate& wrench,
                                     const ReferenceAdmittanceGains& gains) const {
  const Eigen::Array3d force = (gains.desired_force + HeadingOf(body).transpose() * wrench.force_W).array();
  Vec<6> rate;
  rate << x.tail<3>(),
      ((force - gains.damping.array() * x.tail<3>().array() - gains.stiffness.array() * x.head<3>().array()) /
       gains.mass.array())
          .matrix();
  return rate;
}

BodyReference ReferenceAdmittance::CalcModified(const Vec<6>& x, const BodyReference& body,
                                                const WrenchEstimate& wrench,
                                                const ReferenceAdmittanceGains& gains) const {
  const Eigen::Matrix3d R = HeadingOf(body);
  BodyReference modified = body;
  modified.com_W += R * x.head<3>();
  modified.com_velocity_W += R * x.tail<3>();
  modified.com_acceleration_W += R * CalcRate(x, body, wrench, gains).tail<3>();
  return modified;  // neglects the rate of the heading
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::GuideStatus);
TENON_DEFINE_SIGNAL(tenon::AdmittanceMotion);
