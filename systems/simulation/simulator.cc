#include <tenon/systems/framework/context/internal/profiler.h>
#include <tenon/systems/framework/diagram/internal/schedule.h>
#include <tenon/systems/simulation/internal/sundials_integrator.h>
#include <tenon/systems/simulation/simulator.h>

#include <fmt/core.h>

#include <cerrno>
#include <ctime>

namespace tenon {

using internal::Profiled;
using internal::Profiler;
using internal::TickPlan;
using internal::Tiny;

namespace {

/// The clock of real-time runs, CLOCK_MONOTONIC [ns].
std::int64_t Nanoseconds() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Calls a function for each log, even if it throws for one; returns the first exception.
template <class RatedLogs>
std::exception_ptr WithEachLog(const RatedLogs& logs, void (SignalLog::*act)()) {
  std::exception_ptr first;
  for (const auto& rated : logs) {
    for (const auto& each : rated.logs) {
      try {
        ((*each).*act)();
      } catch (...) {
        if (!first) first = std::current_exception();
      }
    }
  }
  return first;
}

/// Events less than this part of the time apart are at one instant: they cannot be told apart.
constexpr double kInstant = 16 * internal::kTimeResolution;
/// Number of successive shrinking intervals between events from which their limit is extrapolated.
constexpr double kSeries = 4;
/// In such a series, the ratio of an interval to the one before changes by less than this factor.
constexpr double kSteady = 4;
/// Parts of Context::event_memory_ for each witness: the time of its last event [s] and its rounding, the
/// number of events at this instant, the last two intervals between two events [s], and the number of
/// successive intervals that were each shorter than the one before, at a steady ratio.
enum { kLast, kRest, kCount, kInterval, kEarlier, kShrinking, kEventMemory };

/// Times of the run are exact enough if their rounding is less than this part of the shortest period of ticks
/// that restart the integrator, or of the longest step if there are none.
constexpr double kExactTime = 1e-8;
constexpr double kLongStep = 0.1;  ///< without a longest step [s]
/// A time that misses a tick by less than this part of the distance to the tick beside it, and by not more
/// than the rounding errors of this many additions and of a sum of periods since the beginning, means the
/// tick.
constexpr double kMisses = 0.01, kAdditions = 16;

/// Returns a pointer that is not null.
template <class Pointer>
Pointer Given(Pointer pointer, const char* what) {
  if (pointer == nullptr) throw ParameterError(fmt::format("Simulator: the {0} is null: give a {0}", what));
  return pointer;
}

/// Throws if the context was changed while it was advanced.
void DemandUnchanged(std::uint64_t edition, std::uint64_t known, double time) {
  if (edition == known) return;
  throw RunError(
      fmt::format("a calculation, a Publish or a log changed the context at t = {} s, but may only read it: "
                  "change states "
                  "by an Update, or by Set between advances",
                  time));
}

/// Explains an error that arose after `end`, the end of the advance, where the caller expects no evaluation.
/// Keeps the original exception nested.
[[noreturn]] void RethrowAsLater(const RunError& error, double end) {
  const RunError later(
      fmt::format(
          "{}. This is after t = {} s, to which the run advances, because integrator steps go past it. If "
          "data end there, hold their last value, or declare their end by a NextJump",
          error.what(), end),
      error.block());
  try {
    std::rethrow_if_nested(error);
  } catch (...) {
    std::throw_with_nested(later);
  }
  throw later;
}

}  // namespace

Simulator::Simulator(const Diagram& diagram, SimulatorOptions options)
    : Simulator(diagram.CreateContext(options.seed.value_or(0)), options) {}

Simulator::Simulator(const std::shared_ptr<const Diagram>& diagram, SimulatorOptions options)
    : Simulator(*Given(diagram, "diagram"), std::move(options)) {}

Simulator::Simulator(std::unique_ptr<Context> context, SimulatorOptions options)
    : context_(Given(std::move(context), "context")),
      options_(std::move(options)),
      program_(context_->diagram().program()),
      integrator_(SundialsIntegrator::Make(*context_, options_)) {
  if (options_.seed && *options_.seed != context_->seed()) {
    throw ParameterError(
        fmt::format("SimulatorOptions: seed = {} applies to a context that the simulator creates, but "
                    "the given context has seed {}: give the seed to Diagram::CreateContext",
                    *options_.seed, context_->seed()));
  }
  if (options_.profile) profiler_ = std::make_unique<Profiler>(program_.calculations.size());
  context_->profiler_ = profiler_.get();
  const auto demand = [](const char* name, double value) {
    if (value >= 0 && std::isfinite(value)) return;
    throw ParameterError(
        fmt::format("SimulatorOptions: {} = {} must be finite and not negative", name, value));
  };
  demand("real_time_rate", options_.real_time_rate);
  demand("late_tolerance", options_.late_tolerance);
  for (const internal::CalculationInfo& info : program_.calculations) {
    if (info.source->kind() == SourceKind::kPublish) context_->Mute(*info.source, !options_.publish);
  }
  context_->checks_values_ = options_.check_values;
  MakeEventFinder();
  watches_steps_ = !program_.each_step.empty() || !program_.each_step_verdicts.empty() || !finder_->empty();
  RebuildSchedule();
}

Simulator::~Simulator() = default;

void Simulator::MakeEventFinder() {
  using Kind = internal::EventFinder::Kind;
  std::vector<Kind> kinds;
  for (const internal::WitnessPlan& plan : program_.witness_plans) {
    const Crossing crossing =
        plan.is_kink ? Crossing::kBoth : static_cast<const Witness*>(plan.witness)->crossing();
    kinds.push_back(plan.is_kink                     ? Kind::kPiece
                    : crossing == Crossing::kRising  ? Kind::kRising
                    : crossing == Crossing::kFalling ? Kind::kFalling
                                                     : Kind::kBoth);
  }
  finder_ = std::make_unique<internal::EventFinder>(
      std::move(kinds), [this](double time, double* values) { integrator_->EvaluateWitnesses(time, values); },
      &context_->witness_memory_);
  witness_values_.resize(program_.witness_plans.size());
  fired_.reserve(program_.witness_plans.size());
}

IntegratorStatistics Simulator::statistics() const {
  return integrator_->statistics();
}

RunProfile Simulator::Profile() const {
  if (!profiler_) throw RunError("this run is not profiled: set SimulatorOptions::profile to true");
  RunProfile profile;
  profile.integrator = profiler_->seconds(Profiler::kIntegrator);
  profile.logs = profiler_->seconds(Profiler::kLogs);
  profile.ticks = profiler_->seconds(Profiler::kTicks);
  profile.waiting = profiler_->seconds(Profiler::kWaiting);
  profile.total = profile.integrator + profile.logs + profile.ticks + profile.waiting;
  for (std::size_t i = 0; i < program_.calculations.size(); ++i) {
    const std::size_t part = Profiler::kCalculations + i;
    if (profiler_->calls(part) == 0) continue;
    profile.calculations.push_back(
        {program_.calculations[i].source->path(), profiler_->calls(part), profiler_->seconds(part)});
    profile.total += profiler_->seconds(part);
  }
  std::ranges::stable_sort(profile.calculations, std::greater<>(), &RunProfile::Entry::seconds);
  return profile;
}

void Simulator::AddMonitor(std::function<Verdict(Context&)> monitor) {
  if (!monitor) throw ParameterError("AddMonitor: give a function, not an empty std::function");
  monitors_.push_back(std::move(monitor));
  watches_steps_ = true;
}

void Simulator::AskMonitors() {
  for (const auto& monitor : monitors_) {
    const std::uint64_t edition = context_->edition_;
    const Verdict verdict = monitor(*context_);
    if (context_->edition_ != edition) {
      throw RunError(
          "a monitor changed the context, but may only read it: change states by an Update, or by Set "
          "between advances");
    }
    if (verdict && !end_reason_) end_reason_ = "monitor: " + *verdict;
  }
}

double Simulator::next_tick_time() const {
  return schedule_->next_time();
}

void Simulator::AddLog(Rate rate, std::vector<const Source*> signals,
                       std::vector<std::shared_ptr<LogSink>> sinks) {
  if (std::count(signals.begin(), signals.end(), nullptr) > 0)
    throw ParameterError("AddLog: a signal is null: give a port or a state");
  auto log = std::make_unique<SignalLog>(*context_, std::move(signals), std::move(sinks));
  auto same = std::find_if(logs_.begin(), logs_.end(), [&](const RatedLog& log) { return log.rate == rate; });
  if (same == logs_.end()) {
    logs_.push_back({rate, {}});
    RebuildSchedule();
    same = logs_.end() - 1;
  }
  same->logs.push_back(std::move(log));
}

std::shared_ptr<MemoryLog> Simulator::AddLog(Rate rate, std::vector<const Source*> signals) {
  auto log = std::make_shared<MemoryLog>();
  AddLog(rate, std::move(signals), {log});
  return log;
}

void Simulator::HoldLogs(double seconds) {
  for (const RatedLog& log : logs_) {
    for (const auto& each : log.logs) each->Hold(seconds);
  }
}

void Simulator::ReleaseLogs() {
  const std::exception_ptr released = WithEachLog(logs_, &SignalLog::Release), flushed = FlushLogs();
  if (released) std::rethrow_exception(released);
  if (flushed) std::rethrow_exception(flushed);
}

void Simulator::RebuildSchedule() {
  std::vector<internal::SampleGroup> entries = program_.groups;
  for (const RatedLog& log : logs_) {
    entries.push_back({{log.rate.numerator(), log.rate.denominator()}, {0, 1}, "a log"});
  }
  schedule_ = std::make_unique<internal::Schedule>(entries);
  MoveSchedule();
  due_.reserve(entries.size());
  double interval = schedule_->shortest_feeding_period();
  if (interval == 0) interval = options_.max_step > 0 ? options_.max_step : kLongStep;
  exact_until_ = kExactTime / Tiny(0) * interval - 1;
}

void Simulator::MoveSchedule() {
  schedule_->MoveTo(context_->time(), context_->progress_ != Context::Progress::kTickDone);
}

/// Finds the place in the schedule again after the context was restored or changed from outside.
void Simulator::Synchronize() {
  if (known_edition_ == context_->edition_ && context_->progress_ != Context::Progress::kNew) return;
  known_edition_ = context_->edition_;
  MoveSchedule();
  const bool tick_done = context_->progress_ == Context::Progress::kTickDone;
  for (const RatedLog& log : logs_) {
    for (const auto& each : log.logs) each->DropFrom(context_->time(), tick_done);
  }
  stop_is_due_ = false;
  end_reason_.reset();
  ended_by_ = nullptr;
  pace_start_.reset();
}

RunStatus Simulator::Initialize() {
  return AdvanceTo(context_->time());
}

RunStatus Simulator::AdvanceTo(double time) {
  return Advance(time, false);
}

RunStatus Simulator::AdvanceToBefore(double time) {
  return Advance(time, true);
}

RunStatus Simulator::Advance(double time, bool before_tick) {
  using Progress = Context::Progress;
  if (!std::isfinite(time))
    throw RunError(fmt::format("cannot advance to t = {} s: give a finite time", time));
  const double period = schedule_->shortest_period(), begin = context_->begin_time_;
  const double additions = kAdditions + (period > 0 ? std::abs(time - begin) / period : 0);
  const double rounding =
      std::min(additions * std::numeric_limits<double>::epsilon() * std::max(std::abs(time), std::abs(begin)),
               kMisses * period);
  if (time < context_->time() - std::max(rounding, 1e-15 * std::abs(time))) {
    throw RunError(
        fmt::format("cannot advance to t = {} s: the run is already at t = {} s", time, context_->time()));
  }
  if (!context_->failure_.empty()) {
    throw RunError(fmt::format(
        "this run failed and cannot continue: {}; restore an earlier snapshot, or start a new run",
        context_->failure_));
  }
  context_->CheckAllFixed();
  if (profiler_) profiler_->Start();
  const Profiled advance(profiler_.get(), Profiler::kTicks);
  try {
    Synchronize();
    if (options_.real_time_rate != 0 && !pace_start_) {
      pace_start_ = Nanoseconds();
      pace_start_time_ = context_->time();
    }
    if (context_->progress_ == Progress::kNew) {
      context_->CheckSamplesFor(program_.at_start.ops);
      context_->Apply(program_.at_start);
      context_->progress_ = Progress::kStarted;
    }
    const bool at_next = MeansNextTick(time, rounding) && schedule_->next_time() == context_->time();
    const bool goes_on = !before_tick || (time > context_->time() && !at_next);
    if (context_->progress_ == Progress::kStarted && goes_on) FirstTick();
    DemandUnchanged(context_->edition_, known_edition_, context_->time());
    while (!end_reason_) {
      const double next = schedule_->next_time();
      const bool meant = MeansNextTick(time, rounding);
      const bool tick = meant ? !before_tick : next < time;
      const double target = meant || tick ? next : time;
      if (!tick && (context_->time() >= target || MeansLastTick(time, rounding))) break;
      try {
        IntegrateTo(target);
      } catch (const RunError& error) {
        if (context_->time() > time) RethrowAsLater(error, time);
        throw;
      }
      if (options_.real_time_rate != 0) KeepPace(tick);
      if (tick && !end_reason_) Tick();
      DemandUnchanged(context_->edition_, known_edition_, context_->time());
    }
    if (context_->progress_ == Progress::kTickDone && schedule_->next_time() <= context_->time())
      context_->progress_ = Progress::kTickDue;
  } catch (const std::exception& error) {
    context_->failure_ = error.what();
    if (context_->failure_.empty()) context_->failure_ = "an exception without a text was thrown";
    static_cast<void>(FlushLogs());  // the first error is the one reported
    throw;
  } catch (...) {
    context_->failure_ = "an object that is not a std::exception was thrown";
    static_cast<void>(FlushLogs());
    throw;
  }
  if (const std::exception_ptr error = FlushLogs()) std::rethrow_exception(error);
  return {context_->time(), end_reason_.has_value(), end_reason_.value_or(""), ended_by_};
}

/// Returns whether `time`, which may be a sum of periods, means the next tick.
bool Simulator::MeansNextTick(double time, double rounding) const {
  const double tick = schedule_->next_time(), miss = std::abs(tick - time);
  return miss == 0 || (miss <= rounding && miss <= kMisses * (tick - schedule_->previous_time()) &&
                       miss <= kMisses * (schedule_->following_time() - tick));
}

/// Returns whether `time`, which is later than the present time, means the tick that has just run.
bool Simulator::MeansLastTick(double time, double rounding) const {
  const double tick = context_->time();
  return time - tick <= rounding && time - tick <= kMisses * (schedule_->next_time() - tick) &&
         context_->progress_ == Context::Progress::kTickDone && tick == schedule_->previous_time();
}

/// The exact time of the next tick minus its double; 0 for another time, and where it is negligible.
double Simulator::RestOf(double time) const {
  return IsCoarse(time) && time == schedule_->next_time() ? schedule_->next_rest() : 0;
}

/// Returns whether what remains until `target` + `rest` is rounding, as after an event, and cannot be
/// integrated.
bool Simulator::IsReached(double target, double rest) const {
  const double remaining = target - context_->time();
  if (!IsCoarse(target)) return remaining <= Tiny(target);
  const double known = context_->time_rest_;
  return remaining + (rest - known) <= 1e-14 * (remaining + std::abs(rest) + std::abs(known));
}

void Simulator::RunTo(double time) {
  const RunStatus status = AdvanceTo(time);
  if (status.ended) throw RunError(fmt::format("the run ended at t = {} s: {}", status.time, status.reason));
}

void Simulator::FirstTick() {
  context_->progress_ = Context::Progress::kTickDone;
  if (schedule_->next_time() == context_->time()) {
    context_->time_rest_ = RestOf(context_->time());
    Tick(true);
  }
  for (const internal::CalculationInfo& info : program_.calculations) {
    const bool output = info.source->kind() == SourceKind::kOutput;
    if (info.sampled && output) context_->CheckSample(info);  // or the run starts between its ticks
  }
  context_->RunStale(program_.published_at_start);
  if (!end_reason_) Judge(program_.each_step_monitors, program_.each_step_verdicts);
  AskMonitors();
}

/// Moves to `target`, which is not later than the next tick that affects a derivative. The integrator runs
/// ahead, step by step if values are read inside; the actions after a step happen at its end.
void Simulator::IntegrateTo(double target) {
  const double rest = RestOf(target);
  if (program_.num_continuous == 0 && !watches_steps_) {
    context_->SetRunTime(target);
    context_->time_rest_ = rest;
    return;
  }
  const Profiled integration(profiler_.get(), Profiler::kIntegrator);
  while (!end_reason_) {
    if (!stop_is_due_ && IsReached(target, rest)) break;
    if (!integrator_->can_go_on()) StartIntegrator();
    const double to = integrator_->Local(target, rest), rounding = integrator_->rounding(to);
    if (!stop_is_due_) {
      DemandUnchanged(context_->edition_, known_edition_,
                      context_->time());  // or the integrator starts again
      integrator_->Advance(watches_steps_ || horizon_ - to > rounding);
      FindEvent(integrator_->begin());
      if (!stop_is_due_) continue;
    }
    if (next_stop_ > to + rounding) {
      integrator_->MoveContext(target, rest);
      return;
    }
    EndStep();
  }
  if (end_reason_) return;
  context_->time_rest_ = rest;
  if (context_->time() < target) {
    context_->SetRunTime(target);
    HandleJumps();  // of witnesses that a declared jump moves across zero
  }
}

/// Puts the witnesses on the sides of their values, unless their sides are known.
void Simulator::StartFinder() {
  if (finder_->empty() || finder_->started()) return;
  EvaluateWitnesses();
  finder_->Start(witness_values_.data(), integrator_->BeginMotion());
  integrator_->EndMotion();
}

/// Starts at the present time and states, towards the next instant at which the dynamics change.
void Simulator::StartIntegrator() {
  context_->RunStale(program_.held);
  StartFinder();
  const double jump = NextJump(), tick = schedule_->next_feeding_time();
  SundialsIntegrator::Interval interval{.end = std::min(jump, tick)};
  ends_at_jump_ = interval.jumps = jump <= tick && std::isfinite(jump);
  interval.local = IsCoarse(std::isinf(interval.end) ? context_->time() : interval.end);
  if (interval.local && tick <= jump) interval.end_rest = schedule_->next_feeding_rest();
  const double time = context_->time(), rest = context_->time_rest_;
  const bool inside = context_->step_start_.valid;
  const std::vector<double> present = inside ? context_->witness_memory_ : std::vector<double>();
  const bool again = integrator_->Start(interval);
  horizon_ = integrator_->Local(interval.end, interval.end_rest);
  next_stop_ = integrator_->finish();
  const double now = again ? integrator_->Local(time, rest) : next_stop_;
  stop_is_due_ = next_stop_ > now;
  is_event_ = false;
  if (finder_->empty()) return;
  if (again) {
    // The step was repeated, and with it the search for the next event in it.
    context_->witness_memory_ = context_->step_start_.witnesses;
    FindEvent(context_->step_start_.searched_from);
    if (next_stop_ <= now) context_->witness_memory_ = present;
    stop_is_due_ = next_stop_ > now;
    integrator_->MoveContext(time, rest);
    return;
  }
  if (inside) context_->witness_memory_.clear();  // it belongs to a time ahead
  StartFinder();
  if (finder_->undecided()) DecideSides();
}

/// Gives witnesses that are zero the side to which the motion takes them.
void Simulator::DecideSides() {
  const double time = context_->time();
  const std::size_t i = finder_->Decide(time, integrator_->reach(), integrator_->BeginMotion());
  integrator_->EndMotion();
  if (i == finder_->size()) return;
  const internal::WitnessPlan& plan = program_.witness_plans[i];
  throw RunError(
      fmt::format(
          "events of witness '{}' accumulate at t = {} s: its updates leave it at zero within rounding, and "
          "the motion then takes it across. Add a Mode for the motion that follows (rest, contact), and "
          "enter it when the speed is small",
          plan.witness->path(), time),
      plan.witness->owner().path());
}

/// The part of Context::event_memory_ for a witness.
double* Simulator::EventMemory(std::size_t witness) {
  std::vector<double>& memory = context_->event_memory_;
  const std::size_t size = kEventMemory * program_.witness_plans.size();
  if (memory.size() != size) {
    memory.assign(size, 0);
    for (std::size_t i = 0; i < size; i += kEventMemory)
      memory[i + kLast] = -std::numeric_limits<double>::infinity();
  }
  return memory.data() + kEventMemory * witness;
}

/// The next declared jump of a block that feeds the integrator [s].
double Simulator::NextJump() {
  double next = std::numeric_limits<double>::infinity();
  if (program_.next_jumps.empty()) return next;
  const double time = context_->time();
  context_->RunStale(program_.jumps);
  for (const Source* source : program_.next_jumps) {
    const double jump = *reinterpret_cast<const double*>(context_->Address(*source));
    if (!(jump > time)) {
      throw RunError(
          fmt::format("'{}' is {} s at t = {} s: a next jump must be later than the time, or kNever",
                      source->path(), jump, time));
    }
    next = std::min(next, jump);
  }
  return next;
}

/// Searches the last step after `from`: the next stop is the first event, or the end of the step.
void Simulator::FindEvent(double from) {
  next_stop_ = integrator_->finish();
  stop_is_due_ = true;
  is_event_ = false;
  if (finder_->empty()) return;
  const bool whole = from == integrator_->begin();
  context_->step_start_.searched_from = from;
  context_->step_start_.witnesses = context_->witness_memory_;
  is_event_ = from < next_stop_ && finder_->Find(from, integrator_->finish(), &next_stop_, &fired_);
  if (!is_event_ || !whole || !EventFeeds()) return;
  // For a multistep method a restart costs more than an event inside a step, unless the derivatives jump
  // there.
  if (internal::IsMultistep(options_.method) && !(KinkFires() && integrator_->JumpsAt(next_stop_))) return;
  if (!integrator_->RetakeBefore(next_stop_)) return;
  context_->witness_memory_ = context_->step_start_.witnesses;
  next_stop_ = integrator_->finish();
  stop_is_due_ = is_event_ = false;
  integrator_->MoveContext(next_stop_);  // from the time of the last evaluation of the search
}

/// Moves to the next stop and runs the actions that are due there.
void Simulator::EndStep() {
  const Profiled end(profiler_.get(), Profiler::kTicks);
  stop_is_due_ = false;
  integrator_->MoveContext(next_stop_);
  const double finish = integrator_->finish();
  const bool at_end = next_stop_ == finish || next_stop_ >= finish - integrator_->rounding(next_stop_);
  // An event inside a step ends the step if it restarts the integrator.
  if (watches_steps_ && (at_end || EventFeeds())) {
    Judge(program_.each_step_monitors, program_.each_step_verdicts);
    AskMonitors();
    Apply(program_.each_step);
  }
  if (is_event_) HandleEvent();
  if (!integrator_->can_go_on()) return;
  if (!at_end) {
    FindEvent(next_stop_);
  } else if (integrator_->ends_before_event()) {
    integrator_->Halt();
  } else if (ends_at_jump_ && next_stop_ >= horizon_) {
    integrator_->Halt();
    HandleJumps();
  }
}

bool Simulator::EventFeeds() const {
  if (!is_event_) return false;
  return std::any_of(fired_.begin(), fired_.end(), [this](std::size_t i) {
    const internal::WitnessPlan& plan = program_.witness_plans[i];
    return plan.is_kink || plan.updates.feeds;
  });
}

void Simulator::Apply(const internal::UpdatePlan& plan) {
  context_->Apply(plan);
  if (plan.feeds) integrator_->Halt();
}

const TickPlan& Simulator::PlanFor(const std::vector<int>& due) {
  for (const auto& plan : plans_) {
    if (std::ranges::equal(plan->groups, due, [](int a, int b) { return a == b; })) return *plan;
  }
  plans_.push_back(std::make_unique<TickPlan>(program_.MakeTick(due)));
  return *plans_.back();
}

/// The first tick of a run sets samples that witnesses may read; later ticks may change witnesses that are
/// known.
void Simulator::Tick(bool first) {
  const auto num_groups = static_cast<int>(program_.groups.size());
  const std::vector<int>& due = schedule_->Take();
  context_->progress_ = Context::Progress::kTickDone;
  auto logs_begin = due.end();
  const TickPlan* plan = nullptr;
  if (due.back() < num_groups) {
    plan = &PlanFor(due);
  } else {
    logs_begin = std::lower_bound(due.begin(), due.end(), num_groups);
    due_.assign(due.begin(), logs_begin);
    if (!due_.empty()) plan = &PlanFor(due_);
  }
  const bool feeds = plan != nullptr && plan->feeds;
  if (feeds && !first) StartFinder();  // before the tick changes any value
  if (plan != nullptr) {
    context_->Invalidate(plan->invalidates);
    context_->RunStale(plan->outputs);
    CheckSamples(*plan);
  }
  for (auto log = logs_begin; log != due.end(); ++log) {
    const Profiled logging(profiler_.get(), Profiler::kLogs);
    for (const auto& each : logs_[static_cast<std::size_t>(*log - num_groups)].logs) each->Sample();
  }
  if (first) StartFinder();
  if (plan != nullptr) {
    Judge(plan->monitors, plan->verdicts);
    context_->Apply(plan->updates);
  }
  if (feeds) {
    integrator_->Halt();
    HandleJumps();
  }
}

/// Throws RunError for a NaN in a sample when it arises, because held samples would spread it downstream.
void Simulator::CheckSamples(const TickPlan& plan) const {
  // Infinite bounds are legitimate.
  if (!options_.check_values ||
      (internal::AllFinite(context_->memory_.get(), plan.doubles) && plan.inspected.empty()))
    return;
  for (const Source* source : plan.due) {
    if (internal::FinitenessOf(*source->type_, context_->Address(*source)) != internal::Finiteness::kNan)
      continue;
    throw RunError(fmt::format("{} at t = {} s: the run cannot continue; check that block and its inputs",
                               context_->DescribeNonFinite(), context_->time()),
                   source->owner().path());
  }
}

void Simulator::Judge(const internal::OpList& ops, const std::vector<const Source*>& verdicts) {
  if (verdicts.empty()) return;
  context_->RunStale(ops);
  for (const Source* source : verdicts) {
    const auto& verdict = *reinterpret_cast<const Verdict*>(context_->Address(*source));
    if (!verdict || end_reason_) continue;
    end_reason_ = source->path() + ": " + *verdict;
    ended_by_ = source;
  }
}

void Simulator::EvaluateWitnesses() {
  context_->RunStale(program_.held);
  context_->RunStale(program_.witnesses);
  context_->ReadWitnesses(witness_values_.data());
}

void Simulator::Fire(std::size_t witness) {
  const internal::WitnessPlan& plan = program_.witness_plans[witness];
  const double now = context_->time();
  double* const events = EventMemory(witness);
  const double rest = context_->time_rest_, interval = now - events[kLast] + (rest - events[kRest]);
  const double before = events[kInterval];
  const double instant = kInstant * std::abs(now);
  const bool same = interval <= instant;
  events[kCount] = same ? events[kCount] + 1 : 1;
  const double steady = interval * events[kEarlier] / (before * before);
  const bool shrinks = interval < before + instant && steady > 1 / kSteady && steady < kSteady;
  events[kShrinking] = shrinks ? events[kShrinking] + 1 : 0;
  events[kEarlier] = before;
  events[kInterval] = interval;
  events[kLast] = now;
  events[kRest] = rest;
  // The sum of the intervals to come, if they shrink like the last one.
  const double left = interval * interval / (before - interval);
  const bool accumulate = events[kShrinking] >= kSeries && interval < before && left <= instant;
  if (accumulate || events[kCount] > options_.max_events) {
    const std::string what =
        accumulate ? "accumulate" : fmt::format("occur {} times at one instant", events[kCount]);
    if (plan.is_kink) {
      throw RunError(
          fmt::format("changes of kink '{}' {} at t = {} s: the state slides along the discontinuity, "
                      "because the derivatives on both sides point towards it. Give the block a Mode for "
                      "the sliding motion, or replace the jump by a steep slope",
                      plan.witness->path(), what, now),
          plan.witness->owner().path());
    }
    throw RunError(
        fmt::format(
            "events of witness '{}' {} at t = {} s: its updates must move the state away from the crossing. "
            "Add a Mode for the motion that follows (rest, contact), and enter it when events are frequent",
            plan.witness->path(), what, now),
        plan.witness->owner().path());
  }
  if (plan.is_kink) {
    // A multistep method crosses a kink by its error test, and restarts only where the derivatives jump.
    if (!internal::IsMultistep(options_.method) || !integrator_->can_go_on() ||
        integrator_->JumpsAt(integrator_->Local(now, context_->time_rest_)))
      integrator_->Halt();
    return;
  }
  if (!same) context_->num_steps_ = context_->movement_ = 0;
  Apply(plan.updates);
}

void Simulator::HandleEvent() {
  if (EventFeeds()) {
    finder_->CheckSpeeds(fired_, integrator_->reach(), integrator_->BeginMotion());
    integrator_->EndMotion();
  }
  for (const std::size_t i : fired_) Fire(i);
  EvaluateWitnesses();
  MeasureRounding();
  for (const std::size_t i : fired_) {
    finder_->StartAgain(i, witness_values_[i], true, program_.witness_plans[i].updates.feeds);
  }
  HandleJumps();
}

void Simulator::MeasureRounding() {
  finder_->MeasureRounding(witness_values_.data(), integrator_->BeginMotion());
  integrator_->EndMotion();
}

bool Simulator::KinkFires() const {
  return std::ranges::any_of(fired_, [this](std::size_t i) { return program_.witness_plans[i].is_kink; });
}

/// Fires the witnesses that were moved across zero at one instant, until none remains. Kinks moved to another
/// piece by a tick or an update are not events, because the integrator restarts there anyway.
void Simulator::HandleJumps() {
  if (finder_->empty()) return;
  StartFinder();
  for (;;) {
    EvaluateWitnesses();
    const std::size_t i = finder_->FindJump(witness_values_.data());
    if (i == finder_->size()) break;
    if (!program_.witness_plans[i].is_kink) {
      Fire(i);
      EvaluateWitnesses();
      MeasureRounding();
    }
    finder_->StartAgain(i, witness_values_[i], false, true);
  }
  finder_->Settle(witness_values_.data());
}

/// Waits for the wall-clock time of the tick, when it exchanges values with the outside.
void Simulator::KeepPace(bool tick) {
  if (end_reason_) return;
  using Duration = std::chrono::duration<double>;
  const Duration since_start((context_->time() - pace_start_time_) / options_.real_time_rate);
  const std::int64_t due = *pace_start_ + std::chrono::round<std::chrono::nanoseconds>(since_start).count();
  if (tick_began_) real_time_.compute.Add(1e-9 * static_cast<double>(Nanoseconds() - *tick_began_));
  tick_began_.reset();
  {
    const Profiled waiting(profiler_.get(), Profiler::kWaiting);
    const timespec until{due / 1'000'000'000, due % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) continue;
  }
  if (!tick) return;
  tick_began_ = Nanoseconds();
  const std::int64_t late = *tick_began_ - due;
  ++real_time_.ticks;
  const double lateness = 1e-9 * static_cast<double>(late);
  real_time_.lateness.Add(lateness);
  if (lateness > real_time_.worst_lateness) {
    real_time_.worst_lateness = lateness;
    real_time_.worst_time = context_->time();
  }
  if (lateness <= options_.late_tolerance) return;
  ++real_time_.missed;
  real_time_.missed_lateness = lateness;
  real_time_.missed_time = context_->time();
  if (options_.late_policy == LatePolicy::kShift) {
    *pace_start_ += late;
  } else if (options_.late_policy == LatePolicy::kStop) {
    throw RunError(fmt::format(
        "the tick at t = {} s begins {:.3g} s late, but {} s are permitted: make the blocks faster, lower "
        "real_time_rate = {}, or choose another late_policy",
        context_->time(), lateness, options_.late_tolerance, options_.real_time_rate));
  }
}

std::exception_ptr Simulator::FlushLogs() {
  return WithEachLog(logs_, &SignalLog::Flush);
}

}  // namespace tenon
