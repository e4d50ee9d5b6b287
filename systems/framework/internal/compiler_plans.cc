#include <fmt/core.h>

#include <algorithm>
#include <set>

#include <tenon/systems/framework/internal/compiler.h>
#include <tenon/systems/framework/internal/schedule.h>
#include <tenon/systems/framework/state.h>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxGroups = 64;
constexpr std::int64_t kMaxInstants = 1'000'000;

}  // namespace

std::uint64_t Compiler::GroupMask(const Source& source) const {
  return source.calculation_ >= 0 ? program_.calculations[source.calculation_].group : 0;
}

void Compiler::FindGroups() {
  std::vector<SampleGroup>& groups = program_.groups;
  for (const Source* source : sources_) {
    if (!source->is_sampled() || source->run_ == nullptr) continue;
    const Rate& rate = source->trigger().sampled.rate;
    const Rational offset = ToRational(source->trigger().sampled.offset, "a sample offset");
    const auto same = [&](const SampleGroup& group) {
      return group.period == Rational{rate.numerator(), rate.denominator()} && group.offset == offset;
    };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) {
      if (groups.size() == kMaxGroups) {
        throw BuildError(fmt::format("'{}' needs a {}th different sample time: use at most {} in one diagram",
                                     source->path(), kMaxGroups + 1, kMaxGroups));
      }
      groups.push_back({{rate.numerator(), rate.denominator()}, offset, source->path()});
      group = groups.end() - 1;
    }
    program_.calculations[source->calculation_].group = std::uint64_t{1} << (group - groups.begin());
  }
}

void Compiler::AppendSinks(const std::vector<const Source*>& sinks, OpList& ops) const {
  for (const Source* sink : sinks) {
    ops.push_back(program_.calculations[sink->calculation_].op);
    ops.back().always = true;
  }
}

/// What has to be computed again when the results of `changed` have changed; they themselves left out.
std::vector<std::uint32_t> Compiler::Downstream(std::vector<int> changed) const {
  std::set<std::uint32_t> found;
  while (!changed.empty()) {
    const int i = changed.back();
    changed.pop_back();
    for (const int next : affects_[i]) {
      if (program_.calculations[next].sampled || !found.insert(static_cast<std::uint32_t>(next)).second)
        continue;
      changed.push_back(next);
    }
  }
  return {found.begin(), found.end()};
}

UpdatePlan Compiler::MakeUpdates(const std::vector<const Source*>& updates) const {
  UpdatePlan plan;
  if (updates.empty()) return plan;
  plan.ops = program_.Needed(updates, Which::kAll);
  AppendSinks(updates, plan.ops);
  std::vector<int> readers;
  for (const Source* update : updates) {
    plan.commits.push_back({update->target_, update});
    if (update->target_->kind() == SourceKind::kContinuous) {
      plan.changes_continuous = true;
    } else if (const auto found = readers_.find(update->target_); found != readers_.end()) {
      readers.insert(readers.end(), found->second.begin(), found->second.end());
    }
  }
  plan.invalidates = Downstream(readers);
  plan.invalidates.insert(plan.invalidates.end(), readers.begin(), readers.end());
  return plan;
}

void Compiler::MakePlans() {
  std::vector<const Source*> derivatives, witnesses, at_start, each_step, step_monitors, continuing;
  for (const Source* source : sources_) {
    const Trigger::When when = source->trigger().when;
    if (source->kind() == SourceKind::kDerivative) derivatives.push_back(source);
    if (source->kind() == SourceKind::kWitness) witnesses.push_back(source);
    if (source->kind() == SourceKind::kMonitor && when == Trigger::When::kEachStep)
      step_monitors.push_back(source);
    if (source->kind() != SourceKind::kUpdate) continue;
    if (when == Trigger::When::kAtStart) at_start.push_back(source);
    if (when == Trigger::When::kEachStep) each_step.push_back(source);
  }
  program_.derivatives = program_.Needed(derivatives, Which::kVarying);
  AppendSinks(derivatives, program_.derivatives);
  program_.witnesses = program_.Needed(witnesses, Which::kVarying);
  AppendSinks(witnesses, program_.witnesses);
  continuing = derivatives;
  continuing.insert(continuing.end(), witnesses.begin(), witnesses.end());
  program_.held = program_.Needed(continuing, Which::kHeld);

  program_.at_start = MakeUpdates(at_start);
  program_.each_step = MakeUpdates(each_step);
  program_.each_step_monitors = program_.Needed(step_monitors, Which::kAll);
  AppendSinks(step_monitors, program_.each_step_monitors);
  program_.each_step_verdicts = step_monitors;
  for (const Source* witness : witnesses) {
    std::vector<const Source*> updates;
    for (const Source* source : sources_) {
      if (source->kind() == SourceKind::kUpdate && source->trigger().witness == witness)
        updates.push_back(source);
    }
    program_.witness_plans.push_back({witness, MakeUpdates(updates)});
  }
  MakeTicks();
}

/// Finds every combination of sample groups that falls due together, by going through one hyperperiod.
void Compiler::MakeTicks() {
  const std::vector<SampleGroup>& groups = program_.groups;
  if (groups.empty()) return;
  Schedule schedule(groups);
  const std::int64_t last = schedule.cycle_end();
  std::set<std::uint64_t> masks;
  for (std::int64_t count = 0; schedule.next_tick() <= last; ++count) {
    if (count == kMaxInstants) {
      throw BuildError(
          fmt::format("the sample times of '{}' and the others repeat only after more than {} instants: "
                      "choose periods that "
                      "are multiples of one another",
                      groups.back().example, kMaxInstants));
    }
    masks.insert(schedule.Take());
  }
  for (const std::uint64_t mask : masks) program_.ticks.push_back(MakeTick(mask));
}

TickPlan Compiler::MakeTick(std::uint64_t groups) const {
  TickPlan plan;
  plan.groups = groups;
  std::vector<const Source*> monitors, updates;
  std::vector<int> changed;
  for (const Source* source : sources_) {
    if ((GroupMask(*source) & groups) == 0) continue;
    if (source->kind() == SourceKind::kOutput && source->run_ != nullptr) {
      plan.due.push_back(source);
      changed.push_back(source->calculation_);
    }
    if (source->kind() == SourceKind::kMonitor) monitors.push_back(source);
    if (source->kind() == SourceKind::kUpdate) updates.push_back(source);
  }
  for (const Source* source : plan.due) {
    if (!source->type_->fixed) plan.movable.push_back(source);
    for (const ScalarRun& run : source->type_->runs) {
      if (run.kind == ScalarKind::kDouble)
        plan.doubles.push_back({source->offset_ + run.offset, run.count, run.kind});
    }
  }
  plan.invalidates = Downstream(changed);
  plan.outputs = program_.Needed(plan.due, Which::kAll, groups);
  plan.monitors = program_.Needed(monitors, Which::kAll);
  AppendSinks(monitors, plan.monitors);
  plan.verdicts = monitors;
  plan.updates = MakeUpdates(updates);
  return plan;
}

}  // namespace tenon::internal
