#pragma once

#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>
#include <utility>

namespace tenon {

enum class GuideMode {
  kMove,  ///< follows the command
  kTurn,  ///< turns to a new direction
  kStop,  ///< stands and waits for a pull
};
constexpr auto EnumNames(GuideMode) {
  return std::array{Named{GuideMode::kMove, "move"}, Named{GuideMode::kTurn, "turn"},
                    Named{GuideMode::kStop, "stop"}};
}

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
            Field("align_time_s", &G::align_time).Positive()};
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
/// the leash.
///
///     ports in   command   command without a person
///                wrench    estimated external wrench; only the horizontal force is used
///                state     state of the robot; only the yaw is used
///                obstacle  true if an obstacle is ahead; false if not connected
///     parameter  gains     SupervisorGains
///     ports out  status    sampled
///                walk      sampled
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
class Supervisor final : public LeafSystem<SupervisorParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<bool> obstacle{this, {"obstacle"}, false};
  Parameter<SupervisorGains> gains{this, {"gains"}, params.gains, "thresholds of pulls and gains of turns"};
  Scratch<GuideStatus> memory{this, "memory", GuideStatus()};
  OutputPort<GuideStatus> status{this,
                                 {"status"},
                                 Sampled{params.rate},
                                 Uses(wrench, state, obstacle, gains, memory),
                                 &Supervisor::CalcStatus};
  OutputPort<WalkCommand> walk{
      this, {"walk"}, Sampled{params.rate}, Uses(command, status), &Supervisor::CalcWalk};

 private:
  GuideStatus CalcStatus(const WrenchEstimate& wrench, const LeggedState& state, const bool& obstacle,
                         const SupervisorGains& gains, GuideStatus& memory) const;
  WalkCommand CalcWalk(const WalkCommand& command, const GuideStatus& status) const;
  bool FeelsPull(const Eigen::Vector2d& force_W, const SupervisorGains& gains, GuideStatus* status) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::GuideStatus);
