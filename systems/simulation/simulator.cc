#include <tenon/systems/simulation/simulator.h>

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <tenon/systems/framework/internal/program.h>
#include <tenon/systems/framework/internal/schedule.h>
#include <tenon/systems/simulation/internal/sundials_integrator.h>

namespace tenon {

using internal::TickPlan;

namespace {

using Clock = std::chrono::steady_clock;

/// Times that differ by less are the same: sums of periods round differently than ticks do, and an interval
/// between the two would be a step of 1e-17 s.
double Rounding(double time) {
  return std::min(1e-10 * (1 + std::abs(time)), 1e-7);
}

/// Events that follow one another faster [s] belong to one instant: chatter creeps on, some 1e-8 s at a time.
constexpr double kInstant = 1e-7;

}  // namespace

Simulator::Simulator(const Diagram& diagram, SimulatorOptions options)
    : Simulator(diagram.CreateContext(options.seed), options) {}

Simulator::Simulator(std::unique_ptr<Context> context, SimulatorOptions options)
    : context_(std::move(context)),
      options_(std::move(options)),
      program_(context_->diagram().program()),
      integrator_(std::make_unique<SundialsIntegrator>(*context_, options_)) {
  witness_values_.resize(program_.witness_plans.size());
  new_witness_values_.resize(program_.witness_plans.size());
  events_.resize(program_.witness_plans.size());
  RebuildSchedule();
}

Simulator::~Simulator() = default;

IntegratorStatistics Simulator::statistics() const {
  return integrator_->statistics();
}

double Simulator::next_tick_time() const {
  return schedule_->next_time();
}

void Simulator::AddLog(Rate rate, std::vector<const Source*> signals,
                       std::vector<std::shared_ptr<LogSink>> sinks) {
  logs_.push_back(
      std::make_unique<RatedLog>(RatedLog{rate, SignalLog(*context_, std::move(signals), std::move(sinks))}));
  RebuildSchedule();
}

std::shared_ptr<MemoryLog> Simulator::AddLog(Rate rate, std::vector<const Source*> signals) {
  auto log = std::make_shared<MemoryLog>();
  AddLog(rate, std::move(signals), {log});
  return log;
}

void Simulator::RebuildSchedule() {
  std::vector<internal::SampleGroup> entries = program_.groups;
  for (const auto& log : logs_) {
    entries.push_back({{log->rate.numerator(), log->rate.denominator()}, {0, 1}, "log"});
  }
  if (entries.size() > 64)
    throw BuildError("more than 64 different sample times and logs: give logs the same rate");
  schedule_ = std::make_unique<internal::Schedule>(std::move(entries));
  schedule_->MoveTo(context_->time(), !context_->started_);
}

/// Finds the place in the schedule again after the context was restored or set by hand.
void Simulator::Synchronize() {
  if (synchronized_time_ == context_->time() && context_->started_) return;
  schedule_->MoveTo(context_->time(), !context_->started_);
  end_reason_.reset();
  pace_start_.reset();
}

RunStatus Simulator::Initialize() {
  return AdvanceTo(context_->time());
}

RunStatus Simulator::AdvanceTo(double time) {
  const double rounding = Rounding(time);
  if (!std::isfinite(time))
    throw RunError(fmt::format("cannot advance to t = {} s: give a finite time", time));
  if (time < context_->time() - rounding) {
    throw RunError(
        fmt::format("cannot advance to t = {} s: the run is at t = {} s already", time, context_->time()));
  }
  try {
    context_->CheckAllFixed();
    Synchronize();
    if (options_.real_time_rate > 0 && !pace_start_) {
      pace_start_ =
          std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
      pace_start_time_ = context_->time();
    }
    if (!context_->started_) Start();
    while (!end_reason_) {
      const bool tick = schedule_->next_time() <= time + rounding;
      if (!tick && context_->time() >= time - rounding) break;
      IntegrateTo(tick ? schedule_->next_time() : time);
      if (tick && !end_reason_) Tick();
      KeepPace();
    }
    synchronized_time_ = context_->time();
  } catch (...) {
    FlushLogs();
    throw;
  }
  FlushLogs();
  return {context_->time(), end_reason_.has_value(), end_reason_.value_or("")};
}

void Simulator::Start() {
  context_->started_ = true;
  context_->CheckSamplesFor(program_.at_start.ops);
  context_->Apply(program_.at_start);
  if (schedule_->next_time() == context_->time()) Tick(true);
  for (const internal::CalculationInfo& info : program_.calculations) {
    if (info.sampled) context_->CheckSample(info);  // all have run, unless the run starts between their ticks
  }
}

void Simulator::IntegrateTo(double end) {
  const bool each_step = !program_.each_step.empty() || !program_.each_step_verdicts.empty();
  if (program_.num_continuous == 0 && program_.witness_plans.empty() && !each_step) {
    context_->SetRunTime(end);
    return;
  }
  // What rounding leaves over, behind a root say, is no interval that could be integrated.
  const auto goes_on = [&] { return end - context_->time() > 1e-14 * (1 + std::abs(end)) && !end_reason_; };
  context_->RunStale(program_.held);
  if (goes_on()) integrator_->Restart(end);
  while (goes_on()) {
    const SundialsIntegrator::Stop stop = integrator_->Advance(each_step);
    if (each_step) AfterStep();
    if (stop == SundialsIntegrator::Stop::kRoot) HandleRoots();
    const bool changed = stop == SundialsIntegrator::Stop::kRoot || !program_.each_step.empty();
    if (changed && goes_on()) {
      context_->RunStale(program_.held);
      integrator_->Restart(end);
    }
  }
  if (context_->time() < end && !end_reason_) context_->SetRunTime(end);
}

/// The first tick of a run gives samples the values that witnesses may read; the others may change them.
void Simulator::Tick(bool first) {
  const std::uint64_t due = schedule_->Take();
  const std::uint64_t own =
      program_.groups.empty() ? 0 : due & (~std::uint64_t{0} >> (64 - program_.groups.size()));
  if (!first) EvaluateWitnesses(witness_values_);
  const TickPlan* plan = nullptr;
  if (own != 0) {
    plan = &*std::lower_bound(program_.ticks.begin(), program_.ticks.end(), own,
                              [](const TickPlan& tick, std::uint64_t mask) { return tick.groups < mask; });
    context_->Invalidate(plan->invalidates);
    context_->RunStale(plan->outputs);
    CheckSamples(*plan);
  }
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    if (due >> (program_.groups.size() + i) & 1) logs_[i]->log.Sample();
  }
  if (first) EvaluateWitnesses(witness_values_);
  if (plan != nullptr) {
    Judge(plan->monitors, plan->verdicts);
    context_->Apply(plan->updates);
  }
  if (!program_.witness_plans.empty()) HandleJumps();
}

/// A sampled NaN would be held and spoil everything downstream: it is reported where it arises.
void Simulator::CheckSamples(const TickPlan& plan) const {
  // A sum of 0 x is 0 unless one is not finite; infinite bounds are legitimate.
  double zero = 0;
  for (const internal::ScalarRun& run : plan.doubles) {
    const auto* x = reinterpret_cast<const double*>(context_->memory_.get() + run.offset);
    for (std::uint32_t i = 0; i < run.count; ++i) zero += 0 * x[i];
  }
  if (zero == 0 && plan.movable.empty()) return;
  for (const Source* source : plan.due) {
    if (internal::FinitenessOf(*source->type_, context_->Address(*source)) != internal::Finiteness::kNan)
      continue;
    throw RunError(fmt::format("{} at t = {} s: the run cannot go on; check that block and what feeds it",
                               context_->DescribeNonFinite(), context_->time()));
  }
}

void Simulator::Judge(const internal::OpList& ops, const std::vector<const Source*>& verdicts) {
  if (verdicts.empty()) return;
  context_->RunStale(ops);
  for (const Source* source : verdicts) {
    const auto& verdict = *reinterpret_cast<const Verdict*>(context_->Address(*source));
    if (verdict && !end_reason_) end_reason_ = source->path() + ": " + *verdict;
  }
}

void Simulator::AfterStep() {
  Judge(program_.each_step_monitors, program_.each_step_verdicts);
  context_->Apply(program_.each_step);
}

void Simulator::EvaluateWitnesses(std::vector<double>& values) {
  if (values.empty()) return;
  context_->RunStale(program_.held);
  context_->RunStale(program_.witnesses);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = *reinterpret_cast<const double*>(context_->Address(*program_.witness_plans[i].witness));
  }
}

void Simulator::Fire(std::size_t witness) {
  const internal::WitnessPlan& plan = program_.witness_plans[witness];
  const double now = context_->time();
  Events& events = events_[witness];
  events.count = std::abs(now - events.instant) <= kInstant ? events.count + 1 : 1;
  events.instant = now;
  if (events.count > options_.max_events) {
    throw RunError(
        fmt::format("witness '{}' fires for the {}th time at t = {} s: its updates must move the state away "
                    "from the crossing",
                    plan.witness->path(), events.count, now));
  }
  context_->Apply(plan.updates);
}

void Simulator::HandleRoots() {
  EvaluateWitnesses(witness_values_);
  const std::vector<int>& roots = integrator_->roots();
  for (std::size_t i = 0; i < roots.size(); ++i) {
    if (roots[i] == 0) continue;
    Fire(i);
    witness_values_[i] = 0;  // on its crossing, whatever the last digit says: no jump
  }
  HandleJumps();
}

/// Fires the witnesses whose sign differs from the last look, until none does.
void Simulator::HandleJumps() {
  for (bool fired = true; fired;) {
    fired = false;
    EvaluateWitnesses(new_witness_values_);
    for (std::size_t i = 0; i < witness_values_.size(); ++i) {
      const double before = witness_values_[i], after = new_witness_values_[i];
      const Crossing crossing = static_cast<const Witness*>(program_.witness_plans[i].witness)->crossing();
      const bool rose = before < 0 && after >= 0, fell = before > 0 && after <= 0;
      witness_values_[i] = after;
      if (!(rose && crossing != Crossing::kFalling) && !(fell && crossing != Crossing::kRising)) continue;
      Fire(i);
      fired = true;
    }
  }
}

void Simulator::KeepPace() {
  if (options_.real_time_rate <= 0) return;
  const std::chrono::duration<double> due((context_->time() - pace_start_time_) / options_.real_time_rate);
  const std::chrono::nanoseconds start(*pace_start_);
  std::this_thread::sleep_until(
      Clock::time_point(start + std::chrono::duration_cast<std::chrono::nanoseconds>(due)));
}

void Simulator::FlushLogs() {
  for (const auto& log : logs_) log->log.Flush();
}

}  // namespace tenon
