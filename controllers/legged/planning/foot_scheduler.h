#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

constexpr auto EnumNames(Leg) {
  return std::array{std::pair{kFrontLeft, kLegNames[0]}, std::pair{kFrontRight, kLegNames[1]},
                    std::pair{kRearLeft, kLegNames[2]}, std::pair{kRearRight, kLegNames[3]}};
}

/// Gait given by groups of legs that swing together, one group after the other.
struct GaitProperties {
  std::vector<std::vector<Leg>> swing_groups;  ///< each leg is in one group
  /// duration of the stance of all feet before each swing; if negative, the time by which a group lifts off
  /// before the group before it lands [s]
  double stance = 0;
  double swing = 0;  ///< duration of a leg's swing [s]
  /// time by which the last leg of a group swings after the first; those in between are evenly spaced [s]
  double stagger = 0;

  static FieldList Fields() {
    return {Required("swing_groups", &GaitProperties::swing_groups),
            Required("stance_s", &GaitProperties::stance),
            Required("swing_s", &GaitProperties::swing).Positive(),
            Field("stagger_s", &GaitProperties::stagger).AtLeast(0)};
  }
  void Validate() const;  ///< throws ParameterError
  GaitTiming Timing() const;
};

/// Whether a group lifts off before the one before it has landed. Without delays of the legs, all feet are in
/// the air in between.
inline bool Flies(const GaitTiming& timing) {
  return timing.stance < 0;
}

struct GaitTable {
  GaitProperties crawl, trot, pace, gallop;

  const GaitProperties& operator[](Gait gait) const;  ///< throws Error for Gait::kStand
  static FieldList Fields() {
    return {Required("crawl", &GaitTable::crawl), Required("trot", &GaitTable::trot),
            Required("pace", &GaitTable::pace), Required("gallop", &GaitTable::gallop)};
  }
};

struct FootSchedulerParams {
  GaitTable gaits;
  double touchdown_force = 0;        ///< force threshold of contact [N]
  double early_touchdown_phase = 0;  ///< swing phase before which contact is ignored
  double late_wait = 0;              ///< longest wait of the gait clock for a late or searching foot [s]
  double search_after = 0;           ///< time without contact after which a stance foot searches [s]
  /// moment, over the distance of a foot from the middle, by which another group must be better to begin [N]
  double start_margin = std::numeric_limits<double>::infinity();
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Contents of a file such as controllers/gaits/standard.yaml, for robots of any weight.
struct GaitFile {
  GaitTable gaits;
  double touchdown_force = 0;        ///< force threshold of contact, over the robot's weight m g
  double early_touchdown_phase = 0;  ///< see FootSchedulerParams
  double late_wait = 0;              ///< see FootSchedulerParams [s]
  double search_after = 0;           ///< see FootSchedulerParams [s]
  double start_margin = std::numeric_limits<double>::infinity();  ///< see FootSchedulerParams, over m g

  static FieldList Fields() {
    return {Required("gaits", &GaitFile::gaits),
            Required("touchdown_force_mg", &GaitFile::touchdown_force)
                .Above(0)
                .Below(0.25)
                .Because("it is below the share of the weight on a foot"),
            Required("early_touchdown_phase", &GaitFile::early_touchdown_phase)
                .Between(0, 1)
                .Because("it is a fraction of the swing"),
            Required("late_wait_s", &GaitFile::late_wait).AtLeast(0),
            Required("search_after_s", &GaitFile::search_after).Positive(),
            Field("start_margin_mg", &GaitFile::start_margin).AtLeast(0).OrInfinite()};
  }
  FootSchedulerParams For(double weight /* [N] */) const;
};

/// Conditions of the transitions of a leg's contact state at a tick.
struct ContactEvents {
  bool lift_off = false;    ///< the swing starts
  bool may_land = false;    ///< the swing phase exceeds early_touchdown_phase
  bool swing_over = false;  ///< the planned end of the swing is reached
  bool wait_over = false;   ///< late_wait has elapsed
  bool loaded = false;      ///< the force exceeds touchdown_force
  bool unloaded = false;    ///< the force has been below touchdown_force for search_after
};

/// The next contact state of a leg, by the first row that applies:
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

/// Determines the contact states of the feet (Morlando 2023, section 2.4.1) from a gait clock and measured
/// forces. The norm of a force is compared with touchdown_force. `timing` is that of the next step, see
/// Pacer; that of `gaits` without steps or if not connected. A change of `gaits` takes effect when a gait
/// starts.
///
/// A step of the gait is a stance of all feet, followed by the swing of one group (GaitTiming). A foot that
/// lands early stands from then on, and the step is not shortened. A foot that has not landed at the end of
/// its swing is late: the gait clock waits for it up to late_wait, then the foot is searching and the next
/// step starts. Hence no leg is in swing or late when a step starts. While a leg that must support the robot
/// is searching, the group of the step does not lift off; the clock waits for that leg as for a late foot.
/// The gait changes at the start of a step, from standing at once.
///
/// **First group.** The others take over the moment of a group G that lifts off. With vertical forces f_i of
/// feet on the corners s_i of a square around the middle, |s_i| = 1, it is in proportion to
///
///     m_G = |sum_{i in G} f_i s_i|:
///
/// the force of a single leg, the difference of the forces of a diagonal pair. A gait without flight that
/// starts from standing begins with the first group of its table, or with the one of least m_G if that is
/// smaller by more than `start_margin`. A trot that starts under a lateral load thus keeps those feet on the
/// ground whose line is nearest to the ZMP.
///
/// The gait clock runs at `clock_rate` while feet swing, except in gaits with flight, whose ballistic motion
/// has its own time, and at 1 otherwise.
///
/// **Flight.** If the stance is negative, the next group lifts off by that time before the group of the
/// present step lands, and all feet are in the air in between. With a single group, all feet swing together.
/// Only CentroidalMpc plans the ballistic motion; a TrunkPlanner cannot.
///
/// **Stagger.** The legs of a group may swing one after the other: a bound becomes a gallop with four beats.
/// The step lasts until the last of them has landed.
class FootScheduler final : public LeafSystem<FootSchedulerParams> {
 public:
  using LeafSystem::LeafSystem;

  /// State of the gait clock.
  struct Memory {
    bool started = false;
    std::array<bool, kNumLegs> lifted{};      ///< the leg's own swing, of this step or the next, has begun
    double waited = 0;                        ///< wait before the lift-off or before the next step [s]
    std::array<double, kNumLegs> unloaded{};  ///< time in stance without force [s]
    ContactSchedule schedule;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"lifted", &Memory::lifted, "", kLegElements},
              {"waited", &Memory::waited, "s"},
              {"unloaded", &Memory::unloaded, "s", kLegElements},
              {"schedule", &Memory::schedule}};
    }
  };

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<GaitTiming> timing{this, {"timing"}, GaitTiming()};
  InputPort<double> clock_rate{this, {"clock_rate"}, 1};
  Parameter<GaitTable> gaits{this, {"gaits"}, params.gaits, "timing of the gaits"};
  Parameter<double> touchdown_force{this,
                                    {"touchdown_force", "N"},
                                    params.touchdown_force,
                                    "force threshold of contact",
                                    Range().Positive()};
  Parameter<double> early_touchdown_phase{this,
                                          {"early_touchdown_phase"},
                                          params.early_touchdown_phase,
                                          "swing phase before which contact is ignored",
                                          Range().Between(0, 1)};
  Parameter<double> late_wait{this,
                              {"late_wait", "s"},
                              params.late_wait,
                              "longest wait of the gait clock for a late or searching foot",
                              Range().AtLeast(0).OrInfinite()};
  Parameter<double> search_after{this,
                                 {"search_after", "s"},
                                 params.search_after,
                                 "time without contact after which a stance foot searches",
                                 Range().Positive().OrInfinite()};
  Parameter<double> start_margin{this,
                                 {"start_margin", "N"},
                                 params.start_margin,
                                 "moment, over the distance of a foot from the middle, by which another "
                                 "group must be better to begin",
                                 Range().AtLeast(0).OrInfinite()};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<ContactSchedule> schedule{
      this,
      {"schedule"},
      Sampled{params.rate},
      Uses(command, foot_forces, timing, clock_rate, gaits, touchdown_force, early_touchdown_phase, late_wait,
           search_after, start_margin, memory),
      &FootScheduler::CalcSchedule};

 private:
  ContactSchedule CalcSchedule(const WalkCommand& command, const FootForces& forces, const GaitTiming& timing,
                               double clock_rate, const GaitTable& gaits, double touchdown_force,
                               double early_touchdown_phase, double late_wait, double search_after,
                               double start_margin, Memory& memory) const;
};

}  // namespace tenon
