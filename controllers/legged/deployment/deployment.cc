#include <tenon/controllers/legged/deployment/deployment.h>
#include <tenon/controllers/legged/whole_body/joint_pd.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon {
namespace {

using enum DeploymentMode;
using Events = DeploymentEvents;

constexpr std::array kTransitions{
    DeploymentTransition{kPassive, &Events::rise, "rise", kStandUp},
    DeploymentTransition{kStandUp, &Events::fault, "fault", kDamp},
    DeploymentTransition{kStandUp, &Events::lie, "lie", kLieDown},
    DeploymentTransition{kStandUp, &Events::done, "done", kStand},
    DeploymentTransition{kStand, &Events::fault, "fault", kDamp},
    DeploymentTransition{kStand, &Events::lie, "lie", kLieDown},
    DeploymentTransition{kStand, &Events::walk, "walk", kWalk},
    DeploymentTransition{kWalk, &Events::fault, "fault", kDamp},
    DeploymentTransition{kWalk, &Events::halt, "halt", kStand},
    DeploymentTransition{kLieDown, &Events::fault, "fault", kDamp},
    DeploymentTransition{kLieDown, &Events::rise, "rise", kStandUp},
    DeploymentTransition{kLieDown, &Events::done, "done", kDamp},
    DeploymentTransition{kDamp, &Events::done, "done", kPassive},
};

/// From 0 to 1 with slope 0 at both ends.
double Smooth(double part) {
  const double s = std::clamp(part, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

bool Repeats(const JointMotion& a, const JointMotion& b, const LeggedState& x, const LeggedState& y) {
  return a.q == b.q && a.qd == b.qd && x.p_WB == y.p_WB && x.q_WB == y.q_WB && x.v_W == y.v_W &&
         x.w_W == y.w_W;
}

}  // namespace

std::span<const DeploymentTransition> DeploymentTransitions() {
  return kTransitions;
}

DeploymentMode NextDeploymentMode(DeploymentMode mode, const DeploymentEvents& events) {
  for (const DeploymentTransition& row : kTransitions)
    if (row.from == mode && events.*row.event) return row.to;
  return mode;
}

std::string DeploymentGraph() {
  std::string graph = "digraph deployment {\n  rankdir=LR; node [shape=box, style=rounded];\n";
  for (const DeploymentTransition& row : kTransitions)
    graph += fmt::format("  {} -> {} [label=\"{}\"];\n", EnumName(row.from), EnumName(row.to), row.name);
  return graph + "}\n";
}

Vec<12> LyingPosture(const QuadrupedDescription& robot) {
  constexpr double kFold = 0.95;
  constexpr int kSamples = 1000;  // of the hip's range
  constexpr double pi = std::numbers::pi;
  Vec<12> lying = robot.stance;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const int hip = kJointsPerLeg * leg + 1, knee = hip + 1;
    const double end = robot.stance[knee] < 0 ? std::max(robot.joint(knee).lower, -0.9 * pi)
                                              : std::min(robot.joint(knee).upper, 0.9 * pi);
    lying[knee] += kFold * (end - lying[knee]);
    const double below = robot.FootPosition(leg, robot.stance)[0];
    const double first = std::max(robot.joint(hip).lower, -pi), last = std::min(robot.joint(hip).upper, pi);
    Vec<12> q = lying;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kSamples; ++i) {
      q[hip] = first + (last - first) * i / kSamples;
      const Eigen::Vector3d foot = robot.FootPosition(leg, q);
      const double off = std::abs(foot[0] - below);
      if (foot[2] < robot.HipPosition(leg, q)[2] && off < least) least = off, lying[hip] = q[hip];
    }
  }
  return lying;
}

Deployment::Deployment(const DeploymentParams& p) : LeafSystem(p) {
  params.robot.CheckMass();
  lying_ = LyingPosture(params.robot);
  const JointPdParams pd = MakeJointPd(params.robot);
  stiffness_ = pd.stiffness;
  stance_damping_ = pd.damping;
  standing_torque_ = StandingTorque(params.robot, params.gravity);
  for (int j = 0; j < kNumJoints; ++j) {
    torque_limit_[j] = params.robot.joint(j).torque_limit;
    speed_limit_[j] = params.robot.joint(j).speed_limit;
    damping_[j] = std::min(pd.damping, torque_limit_[j] / speed_limit_[j]);
  }
}

DeploymentStatus Deployment::Initial() const {
  DeploymentStatus status;
  status.mode = params.initial;
  status.since = 2 * params.rise_time;
  status.from = params.robot.stance;
  status.stiff = status.walking = params.initial == kPassive ? 0 : 1;
  return status;
}

DeploymentFault Deployment::FindFault(const JointMotion& joints, const LeggedState& state, double heartbeat,
                                      const DeploymentLimits& limits, DeploymentStatus& memory) const {
  using enum DeploymentFault;
  const double period = params.rate.period(), rounding = period / 2;
  const double advance = heartbeat - memory.heartbeat;
  const bool repeats = memory.started && Repeats(joints, memory.joints, state, memory.state);
  memory.silence = !memory.started || advance > 0 || heartbeat < 0 ? 0 : memory.silence + period;
  memory.repeated = repeats ? memory.repeated + period : 0;
  memory.joints = joints;
  memory.state = state;
  memory.heartbeat = heartbeat;
  if (memory.silence > limits.timeout - rounding) return kLost;
  if (memory.started && advance > limits.timeout + rounding) return kMissed;
  if (memory.repeated > limits.timeout - rounding) return kFrozen;
  if (state.R_WB()(2, 2) < std::cos(limits.tilt)) return kTilt;
  for (int j = 0; j < kNumJoints; ++j) {
    const JointDescription& joint = params.robot.joint(j);
    if (std::max(joint.lower - joints.q[j], joints.q[j] - joint.upper) > limits.angle_margin) return kAngle;
    if (std::abs(joints.qd[j]) > limits.speed * speed_limit_[j]) return kSpeed;
  }
  if (state.v_W.norm() > limits.trunk_speed) return kEstimator;
  return kNone;
}

DeploymentStatus Deployment::CalcStatus(const double& time, const DeploymentGoal& asked,
                                        const JointMotion& joints, const LeggedState& state,
                                        const double& heartbeat, const DeploymentLimits& limits,
                                        DeploymentStatus& status) const {
  using Goal = DeploymentGoal;
  const double period = params.rate.period();
  Goal goal = asked;
  if (asked != Goal::kStop)
    for (const DeploymentGoalAt& each : params.goals)
      if (each.start < time + period / 2) goal = each.goal;
  DeploymentFault fault = FindFault(joints, state, heartbeat, limits, status);
  if (goal == Goal::kStop) fault = DeploymentFault::kStop;
  if (status.started) status.since += period;
  status.started = true;
  if (goal == Goal::kLie && (status.mode == kPassive || status.mode == kDamp)) status.acknowledged = true;

  DeploymentEvents events;
  events.fault = fault != DeploymentFault::kNone;
  events.lie = goal == Goal::kLie;
  events.walk = goal == Goal::kWalk;
  events.halt = !events.walk;
  events.rise = (goal == Goal::kStand || goal == Goal::kWalk) && !events.fault && status.acknowledged;
  const double duration = status.mode == kDamp ? params.damp_time : params.rise_time;
  events.done = status.since > duration - period / 2;
  const DeploymentMode next = NextDeploymentMode(status.mode, events);
  if (next != status.mode) {
    status.mode = next;
    status.since = 0;
    status.from = joints.q;
    if (next == kDamp && events.fault)
      status.fault = fault, status.fault_time = time, status.acknowledged = false;
  }
  const double step = period / params.ramp_time;
  const bool active = next != kPassive && next != kDamp;
  status.stiff = active ? std::min(1.0, status.stiff + step) : 0;
  status.walking = next == kWalk ? std::min(1.0, status.walking + step) : 0;
  return status;
}

JointCommand Deployment::Damped() const {
  JointCommand command;
  command.kd = damping_;
  return command;
}

JointCommand Deployment::CalcCommand(const DeploymentStatus& now, const Vec<12>& torque,
                                     const JointMotion& joints, const DeploymentLimits& limits,
                                     Vec<12>& last_torque) const {
  if (now.mode == kPassive || now.mode == kDamp) {
    last_torque.setZero();
    return now.mode == kDamp ? Damped() : JointCommand();
  }
  JointCommand command;
  const bool lies = now.mode == kLieDown;
  const double part = Smooth(now.since / params.rise_time);
  const Vec<12>& end = lies ? lying_ : params.robot.stance;
  const double stand = 1 - now.walking;
  command.q = now.from + part * (end - now.from);
  command.kp.setConstant(stand * now.stiff * stiffness_);
  command.kd.setConstant(stand * stance_damping_);
  command.torque = stand * now.stiff * (lies ? 1 - part : 1.0) * standing_torque_ + now.walking * torque;
  const Vec<12> wanted = command.TorqueAt(joints);
  const Vec<12> most = limits.torque * torque_limit_, change = limits.torque_change * torque_limit_;
  last_torque =
      wanted.cwiseMax(last_torque - change).cwiseMin(last_torque + change).cwiseMax(-most).cwiseMin(most);
  command.torque += last_torque - wanted;
  return command;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::DeploymentStatus);
