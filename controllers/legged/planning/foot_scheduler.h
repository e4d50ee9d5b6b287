#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>
#include <utility>
#include <vector>

namespace tenon {

constexpr auto EnumNames(Leg) {
  return std::array{std::pair{kFrontLeft, kLegNames[0]}, std::pair{kFrontRight, kLegNames[1]},
                    std::pair{kRearLeft, kLegNames[2]}, std::pair{kRearRight, kLegNames[3]}};
}

/// A gait as a user writes it down: groups of legs that swing together, one group after the other.
struct GaitProperties {
  std::vector<std::vector<Leg>> swing_groups;  ///< every leg once
  double stance = 0;                           ///< of all four feet, before each swing [s]
  double swing = 0;                            ///< [s]

  static FieldList Fields() {
    return {Required("swing_groups", &GaitProperties::swing_groups),
            Required("stance_s", &GaitProperties::stance), Required("swing_s", &GaitProperties::swing)};
  }
  void Validate() const;  ///< throws ParameterError
  GaitTiming Timing() const;
};

struct GaitTable {
  GaitProperties crawl, trot, pace, gallop;

  const GaitProperties& operator[](Gait gait) const;  ///< not of Gait::kStand
  static FieldList Fields() {
    return {Required("crawl", &GaitTable::crawl), Required("trot", &GaitTable::trot),
            Required("pace", &GaitTable::pace), Required("gallop", &GaitTable::gallop)};
  }
};

struct FootSchedulerParams {
  GaitTable gaits;
  double touchdown_force = 0;        ///< a foot with more touches the ground [N]
  double early_touchdown_phase = 0;  ///< part of the swing before which no touchdown counts
  double late_wait = 0;              ///< how long the clock waits for a late or searching foot [s]
  double search_after = 0;           ///< time without force after which a stance foot searches [s]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// A file such as controllers/gaits/standard.yaml, for robots of any weight; it tells where its numbers come
/// from.
struct GaitFile {
  GaitTable gaits;
  double touchdown_force = 0;        ///< over the robot's weight m g
  double early_touchdown_phase = 0;  ///< as in FootSchedulerParams, and those that follow
  double late_wait = 0;              ///< [s]
  double search_after = 0;           ///< [s]

  static FieldList Fields() {
    return {Required("gaits", &GaitFile::gaits), Required("touchdown_force_mg", &GaitFile::touchdown_force),
            Required("early_touchdown_phase", &GaitFile::early_touchdown_phase),
            Required("late_wait_s", &GaitFile::late_wait),
            Required("search_after_s", &GaitFile::search_after)};
  }
  void Validate() const;  ///< throws ParameterError
  FootSchedulerParams For(double weight /* [N] */) const;
};

/// What decides about a leg's contact at a tick.
struct ContactEvents {
  bool lift_off = false;    ///< its swing begins now
  bool may_land = false;    ///< so much of the swing is over that a touchdown counts
  bool swing_over = false;  ///< the planned touchdown has come
  bool wait_over = false;   ///< the clock waits no longer
  bool loaded = false;      ///< its force is above the threshold
  bool unloaded = false;    ///< it has been below for so long that the foot does not stand
};

/// The leg's next state. The first row that applies:
///
/// | from      | if                    | to        |
/// | --------- | --------------------- | --------- |
/// | any       | lift_off              | swing     |
/// | stance    | unloaded              | searching |
/// | swing     | loaded and may_land   | stance    |
/// | swing     | swing_over            | late      |
/// | late      | loaded                | stance    |
/// | late      | wait_over             | searching |
/// | searching | loaded                | stance    |
ContactState NextContactState(ContactState state, const ContactEvents& events);

/// Decides which feet stand (Morlando 2023, section 2.4.1): by the gait's clock and by the measured forces.
///
///     ports in   command      gait; the velocities are the planners'
///                foot_forces  measured, of the ground on each foot [N]; their norm counts
///     parameters gaits        GaitTable; a gait counts from where it begins
///                touchdown_force, early_touchdown_phase, late_wait, search_after
///     ports out  schedule     sampled
///
/// A step of the gait is a stance of all feet, then the swing of one group (GaitTiming). A foot that lands
/// early stands from there on, without shortening the step. A foot that has not landed at the end of its
/// swing is late: the clock waits for it, at most late_wait, then it is searching and the next step begins.
/// So when a step begins, no leg is in swing or late. While a leg that is to carry the robot alone with
/// others is searching, those others do not lift off; the clock waits for it as for a late foot. Gaits change
/// at the beginning of a step; from standing at once. The gaits of this block have no flight phase: at most
/// one group is in the air.
class FootScheduler final : public LeafSystem<FootSchedulerParams> {
 public:
  using LeafSystem::LeafSystem;

  /// The clock between ticks.
  struct Memory {
    bool started = false;
    bool lifted = false;                      ///< this step's legs have lifted off
    double waited = 0;                        ///< before this lift-off, or before the next step [s]
    std::array<double, kNumLegs> unloaded{};  ///< time in stance without force [s]
    ContactSchedule schedule;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"lifted", &Memory::lifted},
              {"waited", &Memory::waited, "s"},
              {"unloaded", &Memory::unloaded, "s", kLegElements},
              {"schedule", &Memory::schedule}};
    }
  };

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  Parameter<GaitTable> gaits{this, {"gaits"}, params.gaits, "timetables"};
  Parameter<double> touchdown_force{
      this, {"touchdown_force", "N"}, params.touchdown_force, "a foot with more touches the ground"};
  Parameter<double> early_touchdown_phase{this,
                                          {"early_touchdown_phase"},
                                          params.early_touchdown_phase,
                                          "part of the swing before which no touchdown counts"};
  Parameter<double> late_wait{
      this, {"late_wait", "s"}, params.late_wait, "how long the clock waits for a late or searching foot"};
  Parameter<double> search_after{this,
                                 {"search_after", "s"},
                                 params.search_after,
                                 "time without force after which a stance foot searches"};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<ContactSchedule> schedule{this,
                                       {"schedule"},
                                       Sampled{params.rate},
                                       Uses(command, foot_forces, gaits, touchdown_force,
                                            early_touchdown_phase, late_wait, search_after, memory),
                                       &FootScheduler::CalcSchedule};

 private:
  ContactSchedule CalcSchedule(const WalkCommand& command, const FootForces& forces, const GaitTable& gaits,
                               double touchdown_force, double early_touchdown_phase, double late_wait,
                               double search_after, Memory& memory) const;
};

}  // namespace tenon
