#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/diagram/internal/compiler.h>
#include <tenon/systems/framework/diagram/internal/schedule.h>

namespace tenon::internal {

/// Marks the sources that affect a derivative or a witness, through values or through updates of states.
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
  const Schedule check(groups);  // throws if the periods have no common tick
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
  OpList ops = program_.NeededWithSinks(derivatives, Which::kVarying);
  std::erase_if(ops, [&](const Op& op) {  // copies between the same address
    return program_.calculations[op.calculation].source->is_copy_ && op.row[0] == op.row[1];
  });
  program_.derivatives = program_.Batched(ops);
  const std::vector<const Source*> kinks = FindKinks();
  std::vector<const Source*> watched = witnesses;
  watched.insert(watched.end(), kinks.begin(), kinks.end());
  program_.witnesses = program_.Batched(program_.NeededWithSinks(watched, Which::kVarying));
  FindJumps();
  continuing = derivatives;
  continuing.insert(continuing.end(), watched.begin(), watched.end());
  program_.held = program_.Needed(continuing, Which::kHeld);

  program_.at_start = program_.MakeUpdates(at_start);
  program_.published_at_start = program_.NeededWithSinks(published_at_start, Which::kAll);
  program_.each_step = program_.MakeUpdates(each_step);
  program_.each_step_monitors = program_.NeededWithSinks(step_monitors, Which::kAll);
  program_.each_step_verdicts = step_monitors;
  for (const Source* witness : witnesses) {
    std::vector<const Source*> updates;
    for (const Source* source : sources_) {
      if (source->run_ != nullptr && source->trigger().witness == witness) updates.push_back(source);
    }
    program_.witness_plans.push_back({witness, program_.MakeUpdates(updates), false});
  }
  for (const Source* kink : kinks) program_.witness_plans.push_back({kink, {}, true});
}

/// Blocks that derivatives, or derivatives and witnesses, depend on between ticks.
std::unordered_set<const System*> Compiler::FindVaryingBlocks(bool derivatives_alone) const {
  std::unordered_set<const System*> blocks;
  const auto add = [&](const BatchedOps& list) {
    for (const Op& op : list.ops) blocks.insert(&program_.calculations[op.calculation].source->owner());
  };
  add(program_.derivatives);
  if (!derivatives_alone) add(program_.witnesses);
  return blocks;
}

/// Kinks that affect the integration: those of blocks that derivatives depend on and that may change between
/// ticks.
std::vector<const Source*> Compiler::FindKinks() const {
  std::vector<const Source*> kinks;
  const std::unordered_set<const System*> blocks = FindVaryingBlocks(true);
  for (const Source* source : sources_) {
    if (source->kind() == SourceKind::kKink && program_.calculations[source->calculation_].varies &&
        blocks.contains(&source->owner()))
      kinks.push_back(source);
  }
  return kinks;
}

void Compiler::FindJumps() {
  const std::unordered_set<const System*> blocks = FindVaryingBlocks(false);
  for (const Source* source : sources_) {
    if (source->kind() == SourceKind::kNextJump && blocks.contains(&source->owner()))
      program_.next_jumps.push_back(source);
  }
  program_.jumps = program_.NeededWithSinks(program_.next_jumps, Which::kAll);
}

}  // namespace tenon::internal
