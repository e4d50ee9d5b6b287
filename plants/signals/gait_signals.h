#pragma once

#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/signal.h>

#include <algorithm>

namespace tenon {

/// Gaits, by the legs that swing together: none, single legs, diagonal, lateral, front and rear pairs.
enum class Gait { kStand, kCrawl, kTrot, kPace, kGallop };

/// Contact state of a leg.
enum class ContactState {
  kStance,     ///< on the ground, the foot does not move
  kSwing,      ///< in the air, on the way to its foothold
  kLate,       ///< no contact at the end of the swing: the foot is lowered and the gait clock waits
  kSearching,  ///< no contact in stance: the foot is lowered and no leg lifts off
};

/// Contact state and timing of a leg.
struct LegContact {
  ContactState state = ContactState::kStance;
  double phase = 0;             ///< phase of the present stance or swing, 0 to 1
  double time_to_lift_off = 0;  ///< until the next planned lift-off; 0 if none is planned [s]
  double time_to_touchdown =
      0;  ///< until the next planned touchdown; 0 while late or searching, or if none is planned [s]

  bool stance() const { return state == ContactState::kStance; }
  static FieldList Fields() {
    return {{"state", &LegContact::state},
            {"phase", &LegContact::phase},
            {"time_to_lift_off", &LegContact::time_to_lift_off, "s"},
            {"time_to_touchdown", &LegContact::time_to_touchdown, "s"}};
  }
};

/// The timing of a gait. A cycle is a sequence of `num_steps` steps; in each all feet stand for `stance`
/// seconds, then the legs of that step swing for `swing` seconds, one later than the other by their delays.
/// Standing has no steps.
struct GaitTiming {
  int num_steps = 0;
  std::array<int, kNumLegs> step{};      ///< step of the cycle in which each leg swings
  double stance = 0;                     ///< duration of the stance of all feet before each swing [s]
  double swing = 0;                      ///< duration of a leg's swing [s]
  std::array<double, kNumLegs> delay{};  ///< of a leg's swing behind the first one of its step [s]

  /// From the first lift-off of a step to its last touchdown [s].
  double span() const { return swing + *std::max_element(delay.begin(), delay.end()); }
  double step_duration() const { return stance + span(); }
  double cycle() const { return num_steps * step_duration(); }
  /// Duration of a foot's stance from touchdown to lift-off [s].
  double leg_stance() const { return cycle() - swing; }
  static FieldList Fields() {
    return {{"num_steps", &GaitTiming::num_steps},
            {"step", &GaitTiming::step, "", kLegElements},
            {"stance", &GaitTiming::stance, "s"},
            {"swing", &GaitTiming::swing, "s"},
            {"delay", &GaitTiming::delay, "s", kLegElements}};
  }
};

/// Contact states and planned events of the feet. Planned times refer to the gait clock, which waits for late
/// feet.
struct ContactSchedule {
  std::array<LegContact, kNumLegs> legs;
  Gait gait = Gait::kStand;
  GaitTiming timing;
  int step = 0;          ///< present step of the cycle
  double step_time = 0;  ///< gait clock since the start of the step [s]
  int footsteps = 0;     ///< number of steps and gait changes; planners replan when it changes

  /// Number of legs in this state.
  int Count(ContactState state) const {
    return static_cast<int>(std::ranges::count(legs, state, &LegContact::state));
  }
  int num_stance() const { return Count(ContactState::kStance); }
  static FieldList Fields() {
    return {{"legs", &ContactSchedule::legs, "", kLegElements},
            {"gait", &ContactSchedule::gait},
            {"timing", &ContactSchedule::timing},
            {"step", &ContactSchedule::step},
            {"step_time", &ContactSchedule::step_time, "s"},
            {"footsteps", &ContactSchedule::footsteps}};
  }
};

/// User command of a walk, in the frame of the heading.
struct WalkCommand {
  Gait gait = Gait::kStand;
  double forward = 0;              ///< [m/s]
  double left = 0;                 ///< [m/s]
  double yaw_rate = 0;             ///< [rad/s]
  Vec<3> height = Vec<3>::Zero();  ///< CoM height above the nominal one, with its rates [m, m/s, m/s^2]

  static FieldList Fields() {
    return {{"gait", &WalkCommand::gait},
            {"forward", &WalkCommand::forward, "m/s"},
            {"left", &WalkCommand::left, "m/s"},
            {"yaw_rate", &WalkCommand::yaw_rate, "rad/s"},
            {"height", &WalkCommand::height, "m, m/s, m/s^2"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ContactSchedule);
TENON_DECLARE_SIGNAL(tenon::WalkCommand);
