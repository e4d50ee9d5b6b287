#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/controllers/legged/planning/step_timing_adapter.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kClockTolerance = 1e-9;  // above the rounding errors of the clock [s]

/// The number of steps from the present one to the leg's own.
int StepsAhead(const ContactSchedule& schedule, std::size_t leg) {
  const int n = schedule.timing.num_steps;
  return n > 0 ? (schedule.timing.step[leg] - schedule.step + n) % n : 0;
}

/// The planned time of the leg's swing, on the clock of the present step.
struct Swing {
  double lift_off, touchdown;
};
Swing PlannedSwing(const ContactSchedule& schedule, std::size_t leg, int steps_ahead) {
  const GaitTiming& timing = schedule.timing;
  const double begin = steps_ahead * timing.step_duration();
  return {begin + timing.stance + timing.delay[leg],
          begin + (timing.stance + timing.delay[leg] + timing.swing)};
}

bool StepIsOver(const ContactSchedule& schedule) {
  return schedule.step_time >= schedule.timing.step_duration() - kClockTolerance;
}

/// True if a leg of the next step's group has lifted off, as happens in a gait with flight.
bool NextIsInAir(const FootScheduler::Memory& memory) {
  for (std::size_t i = 0; i < kNumLegs; ++i)
    if (memory.lifted[i] && StepsAhead(memory.schedule, i) == 1) return true;
  return false;
}

/// The legs whose lift-off is due and has not happened. Before another gait, the next group of a gait with
/// flight does not lift off.
std::array<bool, kNumLegs> DueLegs(const FootScheduler::Memory& memory, Gait next) {
  const ContactSchedule& schedule = memory.schedule;
  std::array<bool, kNumLegs> due{};
  if (schedule.gait == Gait::kStand) return due;
  const bool next_may = Flies(schedule.timing) && (next == schedule.gait || NextIsInAir(memory));
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    const int ahead = StepsAhead(schedule, i);
    if (memory.lifted[i] || ahead > (next_may ? 1 : 0)) continue;
    due[i] = schedule.step_time >= PlannedSwing(schedule, i, ahead).lift_off - kClockTolerance;
  }
  return due;
}

bool Any(const std::array<bool, kNumLegs>& legs) {
  return std::find(legs.begin(), legs.end(), true) != legs.end();
}

/// True if a leg that must stand during the swing of these legs' groups has no contact.
bool OthersSearch(const ContactSchedule& schedule, const std::array<bool, kNumLegs>& due) {
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    bool lifts = false;
    for (std::size_t j = 0; j < kNumLegs; ++j)
      lifts = lifts || (due[j] && schedule.timing.step[i] == schedule.timing.step[j]);
    if (!lifts && schedule.legs[i].state == ContactState::kSearching) return true;
  }
  return false;
}

/// Updates phases and times to the next events from the clock.
void PlanLegs(const std::array<bool, kNumLegs>& lifted, ContactSchedule* schedule) {
  const GaitTiming& timing = schedule->timing;
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    LegContact& leg = schedule->legs[i];
    leg.phase = leg.time_to_lift_off = leg.time_to_touchdown = 0;
    if (timing.num_steps == 0) continue;
    const int own = StepsAhead(*schedule, i);
    const int steps_ahead = own + (lifted[i] ? timing.num_steps : 0);
    leg.time_to_lift_off = PlannedSwing(*schedule, i, steps_ahead).lift_off - schedule->step_time;
    if (leg.state == ContactState::kSwing || leg.state == ContactState::kLate) {
      const Swing swing = PlannedSwing(*schedule, i, own);
      leg.phase = std::clamp((schedule->step_time - swing.lift_off) / timing.swing, 0.0, 1.0);
      leg.time_to_touchdown = std::max(0.0, swing.touchdown - schedule->step_time);
    } else {
      leg.phase = std::clamp(1 - leg.time_to_lift_off / timing.leg_stance(), 0.0, 1.0);
      if (leg.stance()) leg.time_to_touchdown = leg.time_to_lift_off + timing.swing;
    }
  }
}

/// The moment m_G of the group of a step, see FootScheduler [N].
double MomentOf(const GaitTiming& timing, int step, const FootForces& forces) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
    if (timing.step[leg] != step) continue;
    sum += forces[leg][2] * Eigen::Vector2d(IsFront(leg) ? 1 : -1, IsLeft(leg) ? 1 : -1).normalized();
  }
  return sum.norm();
}

/// The step with which a gait starts from standing.
int FirstStep(const GaitTiming& timing, const FootForces& forces, double start_margin) {
  int first = 0;
  double least = MomentOf(timing, 0, forces) - start_margin;
  for (int step = 1; step < timing.num_steps; ++step) {
    const double moment = MomentOf(timing, step, forces);
    if (moment >= least) continue;
    first = step;
    least = moment;
  }
  return first;
}

void BeginStep(Gait gait, const GaitTable& gaits, const GaitTiming& timing, const FootForces& forces,
               double start_margin, FootScheduler::Memory* memory) {
  ContactSchedule& schedule = memory->schedule;
  ++schedule.footsteps;
  schedule.step_time = 0;
  memory->waited = 0;
  if (gait == schedule.gait && gait != Gait::kStand) {
    for (std::size_t i = 0; i < kNumLegs; ++i)
      if (StepsAhead(schedule, i) == 0) memory->lifted[i] = false;
    schedule.step = (schedule.step + 1) % schedule.timing.num_steps;
    if (timing.num_steps > 0) schedule.timing = timing;
    return;
  }
  const bool starts = schedule.gait == Gait::kStand;
  memory->lifted.fill(false);
  schedule.gait = gait;
  schedule.timing = gait == Gait::kStand   ? GaitTiming{}
                    : timing.num_steps > 0 ? timing
                                           : gaits[gait].Timing();
  schedule.step = starts ? FirstStep(schedule.timing, forces, start_margin) : 0;
  if (Flies(schedule.timing)) {  // begins with the lift-off of the first group
    schedule.step = schedule.timing.num_steps - 1;
    schedule.step_time = schedule.timing.step_duration() + schedule.timing.stance;
    for (std::size_t i = 0; i < kNumLegs; ++i) memory->lifted[i] = StepsAhead(schedule, i) == 0;
  }
}

}  // namespace

void GaitProperties::Validate() const {
  CheckRanges(*this);
  std::array<int, kNumLegs> count{};
  for (const std::vector<Leg>& group : swing_groups) {
    Demand(!group.empty(), "swing_groups has an empty group: remove it");
    for (const Leg leg : group) ++count[leg];
  }
  Demand(!swing_groups.empty(), "swing_groups is empty: give at least one group");
  if (stance < 0) {
    Demand(swing_groups.size() >= 2 && -stance < (swing + stagger) / 2,
           fmt::format("stance_s = {} is negative: a group lifts off before the one before it lands, which "
                       "takes at least two groups and less than half of swing_s + stagger_s = {}",
                       stance, swing + stagger));
  } else {
    Demand(swing_groups.size() >= 2 || stance > 0,
           "swing_groups has one group and stance_s is 0: the feet would never stand");
  }
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    Demand(count[i] == 1, fmt::format("swing_groups must contain each leg once, but contains '{}' {} times",
                                      kLegNames[i], count[i]));
  }
}

GaitTiming GaitProperties::Timing() const {
  GaitTiming timing{.num_steps = static_cast<int>(swing_groups.size()), .stance = stance, .swing = swing};
  for (std::size_t k = 0; k < swing_groups.size(); ++k) {
    const std::vector<Leg>& group = swing_groups[k];
    for (std::size_t n = 0; n < group.size(); ++n) {
      timing.step[group[n]] = static_cast<int>(k);
      if (n > 0)
        timing.delay[group[n]] = stagger * static_cast<double>(n) / static_cast<double>(group.size() - 1);
    }
  }
  return timing;
}

const GaitProperties& GaitTable::operator[](Gait gait) const {
  switch (gait) {
    case Gait::kCrawl:
      return crawl;
    case Gait::kTrot:
      return trot;
    case Gait::kPace:
      return pace;
    case Gait::kGallop:
      return gallop;
    case Gait::kStand:
      break;
  }
  throw Error("standing has no steps: ask for the properties of a gait that walks");
}

void FootSchedulerParams::Validate() const {
  for (const Gait gait : {Gait::kCrawl, Gait::kTrot, Gait::kPace, Gait::kGallop}) {
    try {
      gaits[gait].Validate();
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("gaits.{}: {}", EnumName(gait), error.what()));
    }
  }
}

FootSchedulerParams GaitFile::For(double weight) const {
  return {.gaits = gaits,
          .touchdown_force = touchdown_force * weight,
          .early_touchdown_phase = early_touchdown_phase,
          .late_wait = late_wait,
          .search_after = search_after,
          .start_margin = start_margin * weight};
}

ContactState NextContactState(ContactState state, const ContactEvents& events) {
  if (events.lift_off) return ContactState::kSwing;
  switch (state) {
    case ContactState::kStance:
      return events.unloaded ? ContactState::kSearching : state;
    case ContactState::kSwing:
      if (events.loaded && events.may_land) return ContactState::kStance;
      return events.swing_over ? ContactState::kLate : state;
    case ContactState::kLate:
      if (events.loaded) return ContactState::kStance;
      return events.wait_over ? ContactState::kSearching : state;
    case ContactState::kSearching:
      return events.loaded ? ContactState::kStance : state;
  }
  return state;
}

ContactSchedule FootScheduler::CalcSchedule(const WalkCommand& command, const FootForces& forces,
                                            const GaitTiming& timing, double clock_rate,
                                            const GaitTable& gaits, double touchdown_force,
                                            double early_touchdown_phase, double late_wait,
                                            double search_after, double start_margin, Memory& memory) const {
  const double dt = params.rate.period();
  const auto wait_is_over = [&] { return memory.waited >= late_wait - kClockTolerance; };
  ContactSchedule& schedule = memory.schedule;
  if (!memory.started) {
    memory.started = true;
    BeginStep(command.gait, gaits, timing, forces, start_margin, &memory);
    schedule.footsteps = 0;
  } else {
    if (schedule.gait != Gait::kStand) {
      if (StepIsOver(schedule) || Any(DueLegs(memory, command.gait))) {
        memory.waited += dt;
      } else {
        const bool swings = !Flies(schedule.timing) && schedule.Count(ContactState::kSwing) > 0;
        schedule.step_time += swings ? clock_rate * dt : dt;
      }
    }
    for (int i = 0; i < kNumLegs; ++i) {
      LegContact& leg = schedule.legs[i];
      ContactEvents events;
      events.loaded = forces[i].norm() > touchdown_force;
      double& unloaded = memory.unloaded[i];
      unloaded = leg.stance() && !events.loaded ? unloaded + dt : 0;
      events.unloaded = unloaded >= search_after - kClockTolerance;
      const Swing swing = PlannedSwing(schedule, i, StepsAhead(schedule, i));
      const double swing_time = schedule.step_time - swing.lift_off;
      events.may_land = swing_time >= early_touchdown_phase * schedule.timing.swing - kClockTolerance;
      events.swing_over = schedule.step_time >= swing.touchdown - kClockTolerance;
      events.wait_over = wait_is_over();
      leg.state = NextContactState(leg.state, events);
    }
    const bool late = schedule.Count(ContactState::kLate) > 0;
    if (schedule.gait == Gait::kStand ? command.gait != Gait::kStand : StepIsOver(schedule) && !late) {
      // A group in the air lands in its own step, before another gait begins.
      BeginStep(NextIsInAir(memory) ? schedule.gait : command.gait, gaits, timing, forces, start_margin,
                &memory);
    }
  }
  const std::array<bool, kNumLegs> due = DueLegs(memory, command.gait);
  if (Any(due) && (wait_is_over() || !OthersSearch(schedule, due))) {
    memory.waited = 0;
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      if (!due[i]) continue;
      memory.lifted[i] = true;
      schedule.legs[i].state = NextContactState(schedule.legs[i].state, {.lift_off = true});
    }
  }
  PlanLegs(memory.lifted, &schedule);
  return schedule;
}

double StepTimingAdapter::CalcNext(const LeggedState& state, const BodyReference& body,
                                   const StepTiming& timing) const {
  if (timing.clock_rate == 1) return 1;
  const Eigen::Vector3d z = RotationFromQuaternion(body.q_WB).col(2), w = state.w_W - body.w_W;
  const Eigen::Vector3d tilt = z.cross(state.R_WB().col(2));
  const double predicted = (tilt + timing.lookahead * (w - w.dot(z) * z)).norm();
  return predicted > timing.free_tilt ? timing.clock_rate : 1;
}

}  // namespace tenon
