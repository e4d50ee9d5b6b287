#include <algorithm>

#include <tenon/systems/framework/internal/compiler.h>
#include <tenon/systems/framework/internal/schedule.h>
#include <tenon/systems/framework/state.h>

namespace tenon::internal {

/// Marks what reaches a derivative or a witness: through values, and through states that updates change.
void Compiler::FindFeeders() {
  std::vector<int> open;
  std::unordered_map<const Source*, std::vector<int>> updates;
  for (const Source* source : sources_) {
    if (source->calculation_ < 0 || source->run_ == nullptr) continue;
    const bool sink =
        source->kind() == SourceKind::kDerivative || source->kind() == SourceKind::kWitness ||
        (source->kind() == SourceKind::kUpdate && source->target_->kind() == SourceKind::kContinuous);
    if (sink) open.push_back(source->calculation_);
    if (source->kind() == SourceKind::kUpdate) updates[source->target_].push_back(source->calculation_);
  }
  while (!open.empty()) {
    CalculationInfo& info = program_.calculations[open.back()];
    open.pop_back();
    if (info.feeds) continue;
    info.feeds = true;
    open.insert(open.end(), info.uses.begin(), info.uses.end());
    for (const Slot& slot : info.source->arguments_) {
      if (slot.source == nullptr) continue;
      const auto found = updates.find(&slot.source->Resolve());
      if (found != updates.end()) open.insert(open.end(), found->second.begin(), found->second.end());
    }
  }
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
      groups.push_back({{rate.numerator(), rate.denominator()}, offset, source->path()});
      group = groups.end() - 1;
    }
    CalculationInfo& info = program_.calculations[source->calculation_];
    info.group = static_cast<int>(group - groups.begin());
    group->feeds |= info.feeds;
  }
  const Schedule check(groups);  // throws if they have no common tick
}

void Compiler::MakePlans() {
  std::vector<const Source*> derivatives, witnesses, at_start, each_step, step_monitors, continuing,
      published_at_start;
  for (const Source* source : sources_) {
    const Trigger::When when = source->trigger().when;
    if (source->kind() == SourceKind::kDerivative) derivatives.push_back(source);
    if (source->kind() == SourceKind::kWitness) witnesses.push_back(source);
    if (source->kind() == SourceKind::kMonitor && when == Trigger::When::kEachStep)
      step_monitors.push_back(source);
    const bool publish = source->kind() == SourceKind::kPublish;
    if (source->kind() != SourceKind::kUpdate && !publish) continue;
    if (when == Trigger::When::kAtStart) (publish ? published_at_start : at_start).push_back(source);
    if (when == Trigger::When::kEachStep) each_step.push_back(source);
  }
  OpList ops = program_.Needed(derivatives, Which::kVarying);
  program_.AppendSinks(derivatives, ops);
  std::erase_if(ops, [&](const Op& op) {  // copies onto themselves
    return program_.calculations[op.calculation].source->is_copy_ && op.row[0] == op.row[1];
  });
  program_.derivatives = program_.Batched(ops);
  ops = program_.Needed(witnesses, Which::kVarying);
  program_.AppendSinks(witnesses, ops);
  program_.witnesses = program_.Batched(ops);
  continuing = derivatives;
  continuing.insert(continuing.end(), witnesses.begin(), witnesses.end());
  program_.held = program_.Needed(continuing, Which::kHeld);

  program_.at_start = program_.MakeUpdates(at_start);
  program_.published_at_start = program_.Needed(published_at_start, Which::kAll);
  program_.AppendSinks(published_at_start, program_.published_at_start);
  program_.each_step = program_.MakeUpdates(each_step);
  program_.each_step_monitors = program_.Needed(step_monitors, Which::kAll);
  program_.AppendSinks(step_monitors, program_.each_step_monitors);
  program_.each_step_verdicts = step_monitors;
  for (const Source* witness : witnesses) {
    std::vector<const Source*> updates;
    for (const Source* source : sources_) {
      if (source->run_ != nullptr && source->trigger().witness == witness) updates.push_back(source);
    }
    program_.witness_plans.push_back({witness, program_.MakeUpdates(updates)});
  }
}

}  // namespace tenon::internal
