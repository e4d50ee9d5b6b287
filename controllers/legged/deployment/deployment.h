#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/joint_command.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>

namespace tenon {

enum class DeploymentMode {
  kPassive,  ///< joints without torque
  kStandUp,  ///< moves to the nominal stance by joint PD
  kStand,    ///< holds the nominal stance by joint PD
  kWalk,     ///< applies the torques of the walking controller
  kLieDown,  ///< folds the legs by joint PD
  kDamp,     ///< damped joints, after a fault and after lying down
};

/// The wish of the operator.
enum class DeploymentGoal { kLie, kStand, kWalk, kStop };

/// Why joints are damped.
enum class DeploymentFault {
  kNone,
  kStop,       ///< the stop button
  kLost,       ///< no new state
  kMissed,     ///< the robot's clock has advanced by too much since the last tick
  kFrozen,     ///< joints and state repeat themselves
  kTilt,       ///< the trunk is tilted
  kAngle,      ///< a joint is beyond its range
  kSpeed,      ///< a joint is too fast
  kEstimator,  ///< the estimated velocity of the trunk is impossible
};

/// Conditions of the mode's transitions at a tick.
struct DeploymentEvents {
  bool fault = false;  ///< see DeploymentFault
  bool rise =
      false;  ///< the goal is to stand or to walk, nothing is wrong, and the last fault is acknowledged
  bool lie = false;   ///< the goal is to lie
  bool walk = false;  ///< the goal is to walk
  bool halt = false;  ///< the goal is not to walk
  bool done = false;  ///< the time of the mode is over
};

/// A row of the table of transitions.
struct DeploymentTransition {
  DeploymentMode from;
  bool DeploymentEvents::*event;
  const char* name;  ///< of the event
  DeploymentMode to;
};

/// The table of transitions. In a mode, the first row whose event holds applies; without one, the mode stays.
std::span<const DeploymentTransition> DeploymentTransitions();
DeploymentMode NextDeploymentMode(DeploymentMode mode, const DeploymentEvents& events);
/// The table as a graph in the language of Graphviz.
std::string DeploymentGraph();

/// The limits of Deployment. Ratios are those to the limits of each joint.
struct DeploymentLimits {
  double timeout = 0.015;      ///< longest time without a new state; damping sets in at the tick after it [s]
  double tilt = 0.8;           ///< largest angle between the trunk's z axis and the vertical [rad]
  double angle_margin = 0.15;  ///< largest angle of a joint beyond its range [rad]
  double speed = 1.3;          ///< largest ratio of a joint's speed; falling feet drive joints beyond 1
  double trunk_speed = 5;      ///< largest estimated speed of the trunk [m/s]
  double torque = 1;           ///< largest ratio of a torque
  double torque_change = 0.5;  ///< largest change of a torque from tick to tick, as a ratio

  static FieldList Fields() {
    using L = DeploymentLimits;
    return {Field("timeout_s", &L::timeout).Between(0.001, 1),
            Field("tilt_rad", &L::tilt).Positive(),
            Field("angle_margin_rad", &L::angle_margin).AtLeast(0),
            Field("speed_ratio", &L::speed).Positive(),
            Field("trunk_speed_m_per_s", &L::trunk_speed).Positive(),
            Field("torque_ratio", &L::torque).Above(0).AtMost(1),
            Field("torque_change_ratio", &L::torque_change).Positive()};
  }
};

/// A goal from a time on.
struct DeploymentGoalAt {
  double start = 0;                             ///< time from which the goal holds [s]
  DeploymentGoal goal = DeploymentGoal::kWalk;  ///< lie, stand, walk, or stop, as by the stop button

  static FieldList Fields() {
    return {Required("start_s", &DeploymentGoalAt::start).AtLeast(0),
            Required("goal", &DeploymentGoalAt::goal)};
  }
};

struct DeploymentParams {
  QuadrupedDescription robot = {};                    ///< model of the controller
  DeploymentMode initial = DeploymentMode::kPassive;  ///< mode at the start
  DeploymentLimits limits = {};
  double rise_time = 2;    ///< duration of standing up and of lying down [s]
  double ramp_time = 0.5;  ///< time in which stiffness, and the share of the walking controller, rise [s]
  double damp_time = 2;    ///< duration of damping [s]
  std::vector<DeploymentGoalAt> goals = {};  ///< goals of a run, in order; empty: those of the port `goal`
  double gravity = kGravity;                 ///< [m/s^2]
  Rate rate = Hz(1000);

  static FieldList Fields() {
    using P = DeploymentParams;
    return {{"initial", &P::initial},
            {"goals", &P::goals},
            {"limits", &P::limits},
            Field("rise_time_s", &P::rise_time).Positive(),
            Field("ramp_time_s", &P::ramp_time).Positive(),
            Field("damp_time_s", &P::damp_time).Positive(),
            Undescribed(&P::robot),
            Undescribed(&P::gravity),
            Undescribed(&P::rate)};
  }
};

/// Joint angles of a robot that lies: knees folded nearly to the end of their range, the feet below the
/// places that they have in the stance, seen from above.
Vec<12> LyingPosture(const QuadrupedDescription& robot);

/// Mode of Deployment, and what it remembers.
struct DeploymentStatus {
  DeploymentMode mode = DeploymentMode::kPassive;
  double since = 0;                                ///< time in the mode [s]
  DeploymentFault fault = DeploymentFault::kNone;  ///< the last one that damped the joints
  double fault_time = 0;                           ///< its time [s]
  Vec<12> from = Vec<12>::Zero();                  ///< joint angles at the change of the mode [rad]
  bool started = false;
  bool acknowledged = true;  ///< the goal was to lie after the last fault
  double stiff = 0;          ///< share of the stiffness
  double walking = 0;        ///< share of the walking controller
  double heartbeat = 0;      ///< the last one [s]
  double silence = 0;        ///< time since the heartbeat advanced [s]
  double repeated = 0;       ///< time since joints or state changed [s]
  JointMotion joints;        ///< the last ones
  LeggedState state;         ///< the last one

  static FieldList Fields() {
    using S = DeploymentStatus;
    return {{"mode", &S::mode},
            {"since", &S::since, "s"},
            {"fault", &S::fault},
            {"fault_time", &S::fault_time, "s"},
            {"from", &S::from, "rad", kJointElements},
            {"started", &S::started},
            {"acknowledged", &S::acknowledged},
            {"stiff", &S::stiff},
            {"walking", &S::walking},
            {"heartbeat", &S::heartbeat, "s"},
            {"silence", &S::silence, "s"},
            {"repeated", &S::repeated, "s"},
            {"joints", &S::joints},
            {"state", &S::state}};
  }
};

/// The supervisor between a walking controller and the drives of a robot: it stands up, lets the controller
/// walk, lies down, and damps the joints if something is wrong.
///
/// Without `goal` it is to walk; kStop counts beside `goals`, too. `heartbeat`, the robot's time of the last
/// state that arrived, is not watched if it is not connected. The walking controller must stand unless the
/// mode of `status` is kWalk.
///
/// **Modes** change by the rows of DeploymentTransitions. Joint PD has the gains of MakeJointPd; its
/// reference moves from the angles at the change of mode to the posture within `rise_time`. The stiffness
/// rises within `ramp_time`, and so does the share of the walking controller in kWalk. A robot that starts in
/// another mode than kPassive has both at once.
///
/// **Faults.** Each damps the joints at the tick that sees it: kp and torque are 0, and kd is that of
/// MakeJointPd, but not more than gives the torque limit at the speed limit. The drives damp with their own
/// measurement, so this holds without a link, too. After `damp_time` the joints are passive. Then the goal
/// must be to lie before the robot stands up again.
///
/// Numbers that are not finite do not reach a block: DdsInput and UdpInput refuse them, which is silence, and
/// a number of the diagram that is not finite ends the run.
///
/// **Limits.** The torque of a command at the measured joints is kept within the limit and within the change
/// per tick, by its feedforward.
class Deployment final : public LeafSystem<DeploymentParams> {
 public:
  /// Throws ParameterError for a robot without mass.
  explicit Deployment(const DeploymentParams& params);

  /// The command that damps the joints.
  JointCommand Damped() const;

  InputPort<DeploymentGoal> goal{this, {"goal"}, DeploymentGoal::kWalk};
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<double> heartbeat{this, {"heartbeat", "s"}, -1};
  Parameter<DeploymentLimits> limits{this, {"limits"}, params.limits, "limits of motion, torque and delay"};
  Scratch<DeploymentStatus> memory{this, "memory", Initial()};
  Scratch<Vec<12>> last_torque{this, "last_torque"};
  OutputPort<DeploymentStatus> status{this,
                                      {"status"},
                                      Sampled{params.rate},
                                      Uses(time, goal, joints, state, heartbeat, limits, memory),
                                      &Deployment::CalcStatus};
  OutputPort<JointCommand> command{this,
                                   {"command"},
                                   Sampled{params.rate},
                                   Uses(status, torque, joints, limits, last_torque),
                                   &Deployment::CalcCommand};

 private:
  DeploymentStatus Initial() const;
  DeploymentStatus CalcStatus(const double& time, const DeploymentGoal& asked, const JointMotion& joints,
                              const LeggedState& state, const double& heartbeat,
                              const DeploymentLimits& limits, DeploymentStatus& memory) const;
  DeploymentFault FindFault(const JointMotion& joints, const LeggedState& state, double heartbeat,
                            const DeploymentLimits& limits, DeploymentStatus& memory) const;
  JointCommand CalcCommand(const DeploymentStatus& now, const Vec<12>& torque, const JointMotion& joints,
                           const DeploymentLimits& limits, Vec<12>& last_torque) const;

  Vec<12> lying_, standing_torque_ = Vec<12>::Zero();
  Vec<12> torque_limit_, speed_limit_, damping_;
  double stiffness_ = 0, stance_damping_ = 0;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::DeploymentStatus);
