#pragma once

#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

#include <array>
#include <utility>

namespace tenon {

/// Legs that swing together: none, one after the other, diagonal pairs, lateral pairs, front and rear pairs.
enum class Gait { kStand, kCrawl, kTrot, kPace, kGallop };
constexpr auto EnumNames(Gait) {
  return std::array{Named{Gait::kStand, "stand"}, Named{Gait::kCrawl, "crawl"}, Named{Gait::kTrot, "trot"},
                    Named{Gait::kPace, "pace"}, Named{Gait::kGallop, "gallop"}};
}

/// What a leg does.
enum class ContactState {
  kStance,     ///< stands: carries weight, its foot does not move
  kSwing,      ///< in the air, on the way to its foothold
  kLate,       ///< the swing is over but the ground was not found: lowers, and the gait clock waits
  kSearching,  ///< should stand but feels no ground: lowers, and no leg lifts off meanwhile
};
constexpr auto EnumNames(ContactState) {
  return std::array{Named{ContactState::kStance, "stance"}, Named{ContactState::kSwing, "swing"},
                    Named{ContactState::kLate, "late"}, Named{ContactState::kSearching, "searching"}};
}

/// One leg in the schedule.
struct LegContact {
  ContactState state = ContactState::kStance;
  double phase = 0;             ///< of the planned stance or swing that it is in, 0 to 1 [1]
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
/// seconds, then the legs of that step swing for `swing` seconds. Standing has no steps.
struct GaitTiming {
  int num_steps = 0;
  std::array<int, kNumLegs> step{};  ///< in which step of the cycle each leg swings
  double stance = 0;                 ///< of all four feet, before each swing [s]
  double swing = 0;                  ///< [s]

  double step_duration() const { return stance + swing; }
  double cycle() const { return num_steps * step_duration(); }
  /// How long a foot stands between its touchdown and its lift-off [s].
  double leg_stance() const { return cycle() - swing; }
  /// The part of the cycle in which a foot stands; 1 if the robot stands.
  double duty() const { return num_steps == 0 ? 1 : leg_stance() / cycle(); }
  /// The part of the cycle after which a leg lifts off.
  double lift_off_phase(int leg) const {
    if (num_steps == 0) return 0;
    return (step[static_cast<std::size_t>(leg)] * step_duration() + stance) / cycle();
  }
  static FieldList Fields() {
    return {{"num_steps", &GaitTiming::num_steps},
            {"step", &GaitTiming::step, "", kLegElements},
            {"stance", &GaitTiming::stance, "s"},
            {"swing", &GaitTiming::swing, "s"}};
  }
};

/// Which feet stand, now and next. Planned times are those of the gait clock, which waits for late feet.
struct ContactSchedule {
  std::array<LegContact, kNumLegs> legs;
  Gait gait = Gait::kStand;
  GaitTiming timing;
  int step = 0;          ///< of the cycle
  double step_time = 0;  ///< gait clock since the beginning of the step [s]
  int footsteps = 0;     ///< counts the beginnings of steps and the changes of gait: planners replan on it

  int num_stance() const {
    int count = 0;
    for (const LegContact& leg : legs) count += leg.stance();
    return count;
  }
  static FieldList Fields() {
    return {{"legs", &ContactSchedule::legs, "", kLegElements},
            {"gait", &ContactSchedule::gait},
            {"timing", &ContactSchedule::timing},
            {"step", &ContactSchedule::step},
            {"step_time", &ContactSchedule::step_time, "s"},
            {"footsteps", &ContactSchedule::footsteps}};
  }
};

/// How the user wants the robot to go, in the frame of its heading.
struct WalkCommand {
  Gait gait = Gait::kStand;
  double forward = 0;              ///< [m/s]
  double left = 0;                 ///< [m/s]
  double yaw_rate = 0;             ///< [rad/s]
  Vec<3> height = Vec<3>::Zero();  ///< of the CoM above the nominal one, with its rates [m, m/s, m/s^2]

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
