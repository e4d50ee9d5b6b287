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
  kMove,  ///< goes as commanded
  kTurn,  ///< goes into a new direction
  kStop,  ///< stands and waits for a pull
};
constexpr auto EnumNames(GuideMode) {
  return std::array{Named{GuideMode::kMove, "move"}, Named{GuideMode::kTurn, "turn"},
                    Named{GuideMode::kStop, "stop"}};
}

/// What is tuned of the supervisor. Defaults: see docs/guide_dog.md.
struct SupervisorGains {
  double threshold = 50;            ///< sigma: a force above it is a pull [N]
  double release = 40;              ///< below it, a pull is over [N]
  double stop_time = 0.1;           ///< for which a pull must last to stop the robot [s]
  double start_time = 0.3;          ///< for which it must last to start it [s]
  double dwell = 1;                 ///< in a mode before pulls count, and until an obstacle is forgotten [s]
  double turn_rate = 0.3;           ///< at most [rad/s]
  double turn_gain = 1;             ///< turning rate over heading error [1/s]
  double heading_tolerance = 0.02;  ///< within which the robot has the new direction [rad]
  double align_time = 0.3;          ///< for which it must; in a stumble the trunk passes through [s]

  static FieldList Fields() {
    using G = SupervisorGains;
    return {{"threshold_N", &G::threshold},
            {"release_N", &G::release},
            {"stop_time_s", &G::stop_time},
            {"start_time_s", &G::start_time},
            {"dwell_s", &G::dwell},
            {"turn_rate_rad_per_s", &G::turn_rate},
            {"turn_gain_per_s", &G::turn_gain},
            {"heading_tolerance_rad", &G::heading_tolerance},
            {"align_time_s", &G::align_time}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct SupervisorParams {
  SupervisorGains gains;
  Rate rate = Hz(100);
  void Validate() const { gains.Validate(); }  ///< throws ParameterError
};

/// What decides about the mode at a tick.
struct GuideEvents {
  bool pulled = false;        ///< the person has given a command by the leash
  bool obstacle = false;      ///< there is one
  bool new_obstacle = false;  ///< and not the one that was there as the robot stood
  bool aligned = false;       ///< the robot heads in the new direction
};

/// The next mode. The first row that applies, or as it is:
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

/// The supervisor between ticks.
struct GuideStatus {
  GuideMode mode = GuideMode::kMove;
  double since = 0;                ///< time in the mode [s]
  double yaw = 0;                  ///< the new direction; 0 before there is one [rad]
  double pull_time = 0;            ///< evidence of a pull, see Supervisor [s]
  Vec<2> pull_W = Vec<2>::Zero();  ///< sum of the force while there is evidence [N]
  double calm_time = 0;            ///< evidence of none [s]
  bool released = true;            ///< the last pull is over: the next one counts
  bool seen = false;               ///< an obstacle was there as the robot stood, and is not forgotten
  double unseen_time = 0;          ///< since an obstacle was there last [s]
  double aligned_time = 0;         ///< evidence that the turn is done [s]
  double yaw_rate = 0;             ///< of a turn [rad/s]

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

/// Decides when a guide dog goes, stops and turns: Morlando 2023, algorithm 1, with the force of the leash as
/// it is estimated.
///
///     ports in   command   where the robot would go alone
///                wrench    estimated, without gravity and ground; its horizontal force counts
///                state     for the yaw, nothing else
///                obstacle  one is ahead, or another danger; none if not connected
///     parameter  gains     SupervisorGains
///     ports out  status    sampled
///                walk      sampled
///
/// In motion the command passes. Stopped, the robot stands. A pull on the standing robot makes it go on in
/// the direction of the pull, yaw = atan2(f_y, f_x): it turns on an arc, with the commanded velocities and
/// yaw_rate = turn_gain (yaw - heading) within turn_rate, and when it heads there goes as commanded again:
/// when time within heading_tolerance, counted as for pulls below, has come to align_time. It must look away
/// from what stopped it: an obstacle that was there while it stood does not count until it has gone, for
/// `dwell` since a robot that sways loses sight of it and sees it again, or the turn is over. Then one that
/// is ahead stops the robot even if the person pulled that way.
///
/// **Pulls.** The algorithm compares |f| with sigma. So that noise gives no command and a pull gives one
/// only: time above the threshold counts for a pull, time below against it, down to none; it is a command
/// when stop_time or start_time have come together, `dwell` after the last change of mode at the earliest,
/// and only if since the last command the force has in the same way been below `release` for stop_time. The
/// direction is that of the mean force while there was evidence.
class Supervisor final : public LeafSystem<SupervisorParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<bool> obstacle{this, {"obstacle"}, false};
  Parameter<SupervisorGains> gains{
      this, {"gains"}, params.gains, "what counts as a pull, and how the robot turns"};
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
