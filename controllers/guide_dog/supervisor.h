#pragma once

#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

enum class GuideMode {
  kMove,  ///< follows the command
  kTurn,  ///< turns to a new direction
  kStop,  ///< stands and waits for a pull
};

/// Gains of Supervisor. The defaults are explained in docs/guide_dog.md.
struct SupervisorGains {
  double threshold = 50;    ///< tension sigma above which the leash counts as pulled [N]
  double release = 40;      ///< tension below which a pull ends [N]
  double stop_time = 0.1;   ///< duration of a pull that stops the robot [s]
  double start_time = 0.3;  ///< duration of a pull that starts the robot [s]
  double dwell = 1;         ///< time in a mode without evaluation of pulls, and memory of obstacles [s]
  double turn_rate = 0.3;   ///< limit of the yaw rate [rad/s]
  double turn_gain = 1;     ///< gain from the heading error to the yaw rate [1/s]
  double heading_tolerance = 0.02;  ///< heading error below which the robot counts as aligned [rad]
  double align_time = 0.3;          ///< time within heading_tolerance that ends a turn [s]
  double leash_stiffness = 0;       ///< k, see Supervisor; 0 if the person's speed does not matter [N/m]
  double stop_speed = 0.3;          ///< speed of the person below which a pull stops the robot [m/s]
  double speed_filter = 0.1;        ///< time constant of the estimate of the person's speed [s]

  static FieldList Fields() {
    using G = SupervisorGains;
    return {Field("threshold_N", &G::threshold).Positive(),
            Field("release_N", &G::release).Positive(),
            Field("stop_time_s", &G::stop_time).Positive(),
            Field("start_time_s", &G::start_time).Positive(),
            Field("dwell_s", &G::dwell).AtLeast(0),
            Field("turn_rate_rad_per_s", &G::turn_rate).Positive(),
            Field("turn_gain_per_s", &G::turn_gain).Positive(),
            Field("heading_tolerance_rad", &G::heading_tolerance).Positive(),
            Field("align_time_s", &G::align_time).Positive(),
            Field("leash_stiffness_N_per_m", &G::leash_stiffness).AtLeast(0),
            Field("stop_speed_m_per_s", &G::stop_speed).Positive(),
            Field("speed_filter_s", &G::speed_filter).Positive()};
  }
  void Validate() const;  ///< throws ParameterError
};

struct SupervisorParams {
  SupervisorGains gains;
  Rate rate = Hz(100);
};

/// Conditions of the mode's transitions at a tick.
struct GuideEvents {
  bool pulled = false;        ///< the person has pulled the leash
  bool obstacle = false;      ///< an obstacle is ahead
  bool new_obstacle = false;  ///< an obstacle is ahead that was not there while the robot stood
  bool aligned = false;       ///< the robot heads in the new direction
};

/// Returns the mode of the first row that applies, or `mode` if none does:
///
/// | from | if           | to   |
/// | ---- | ------------ | ---- |
/// | move | pulled       | stop |
/// | move | obstacle     | stop |
/// | turn | pulled       | stop |
/// | turn | new_obstacle | stop |
/// | turn | aligned      | move |
/// | stop | pulled       | turn |
GuideMode NextGuideMode(GuideMode mode, const GuideEvents& events);

/// State of Supervisor.
struct GuideStatus {
  GuideMode mode = GuideMode::kMove;
  double since = 0;                ///< time in the mode [s]
  double yaw = 0;                  ///< the new direction; 0 before the first turn [rad]
  double pull_time = 0;            ///< accumulated time of a pull, see Supervisor [s]
  Vec<2> pull_W = Vec<2>::Zero();  ///< sum of the force while pull_time > 0 [N]
  double calm_time = 0;            ///< accumulated time below `release` [s]
  bool released = true;            ///< the last pull has ended
  bool seen = false;               ///< an obstacle was ahead while the robot stood, and is remembered
  double unseen_time = 0;          ///< time since an obstacle was last ahead [s]
  double aligned_time = 0;         ///< accumulated time within heading_tolerance [s]
  double yaw_rate = 0;             ///< yaw rate of a turn [rad/s]

  static FieldList Fields() {
    using S = GuideStatus;
    return {{"mode", &S::mode},
            {"since", &S::since, "s"},
            {"yaw", &S::yaw, "rad"},
            {"pull_time", &S::pull_time, "s"},
            {"pull_W", &S::pull_W, "N"},
            {"calm_time", &S::calm_time, "s"},
            {"released", &S::released},
            {"seen", &S::seen},
            {"unseen_time", &S::unseen_time, "s"},
            {"aligned_time", &S::aligned_time, "s"},
            {"yaw_rate", &S::yaw_rate, "rad/s"}};
  }
};

/// Decides when a guide dog moves, stops and turns (Morlando 2023, algorithm 1), with the estimated force of
/// the leash. Only the horizontal force of `wrench` and the yaw and velocity of `state` are used.
///
/// While moving, the command passes unchanged; when stopped, the robot stands. A pull on the standing robot
/// starts a turn into the direction of the pull, yaw = atan2(f_y, f_x): the robot walks an arc with the
/// commanded velocities and yaw_rate = turn_gain (yaw - heading), limited to turn_rate. The turn ends when
/// the accumulated time within heading_tolerance (see below) reaches align_time. An obstacle that was ahead
/// while the robot stood is ignored until it has been out of sight for `dwell`, since a swaying robot loses
/// and regains it, or until the turn is over. Afterwards an obstacle ahead stops the robot even in the
/// direction of the pull.
///
/// **Pulls.** The algorithm compares |f| with sigma. To reject noise and to detect each pull once, the time
/// above the threshold is accumulated and the time below is subtracted, down to 0. A pull is detected when
/// this time reaches stop_time or start_time, no earlier than `dwell` after the last change of mode, and only
/// if the force has been below `release` for stop_time, accumulated alike, since the last pull. The direction
/// of a pull is that of the mean force while the accumulated time is positive.
///
/// **Pace.** At a person's pace, a person who sets out or slows down pulls as hard as one who stops. A leash
/// of the stiffness k that the person holds tells them apart: its tension T changes with k times the
/// difference of the speeds of robot and person, so
///
///     v_person = F (v - T' / k),   F = 1 / (1 + speed_filter s),
///
/// with T and v along the heading. With leash_stiffness = k above 0, a pull on a moving robot only counts
/// while v_person is below stop_speed.
class Supervisor final : public LeafSystem<SupervisorParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<bool> obstacle{this, {"obstacle"}, false};
  Parameter<SupervisorGains> gains{this, {"gains"}, params.gains, "thresholds of pulls and gains of turns"};
  struct Memory {
    GuideStatus status;
    bool started = false;
    double tension = 0;       ///< filtered backward pull along the heading [N]
    double speed = 0;         ///< filtered speed of the robot along the heading [m/s]
    double person_speed = 0;  ///< v_person [m/s]

    static FieldList Fields() {
      return {{"status", &Memory::status},
              {"started", &Memory::started},
              {"tension", &Memory::tension, "N"},
              {"speed", &Memory::speed, "m/s"},
              {"person_speed", &Memory::person_speed, "m/s"}};
    }
  };
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<Memory> progress{this,
                              {"progress"},
                              Sampled{params.rate},
                              Uses(wrench, state, obstacle, gains, memory),
                              &Supervisor::CalcProgress};
  OutputPort<GuideStatus> status{
      this, {"status"}, Sampled{params.rate}, Uses(progress), [](const Memory& m) { return m.status; }};
  OutputPort<WalkCommand> walk{
      this, {"walk"}, Sampled{params.rate}, Uses(command, status), &Supervisor::CalcWalk};

 private:
  Memory CalcProgress(const WrenchEstimate& wrench, const LeggedState& state, const bool& obstacle,
                      const SupervisorGains& gains, Memory& memory) const;
  WalkCommand CalcWalk(const WalkCommand& command, const GuideStatus& status) const;
  void EstimatePerson(const Eigen::Vector2d& force_W, const LeggedState& state, const SupervisorGains& gains,
                      Memory* memory) const;
  bool FeelsPull(const Eigen::Vector2d& force_W, bool counts, const SupervisorGains& gains,
                 GuideStatus* status) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::GuideStatus);
