#include <tenon/systems/framework/internal/program.h>

#include <algorithm>
#include <set>

namespace tenon::internal {

OpList Program::Needed(const std::vector<const Source*>& sinks, Which which, const Groups& due) const {
  std::vector<int> open;
  for (const Source* sink : sinks) {
    const CalculationInfo& info = calculations[sink->calculation_];
    if (info.sampled) {
      open.push_back(sink->calculation_);
    } else {
      open.insert(open.end(), info.uses.begin(), info.uses.end());
    }
  }
  std::vector<bool> wanted(calculations.size(), false);
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    const CalculationInfo& info = calculations[i];
    if (wanted[i] || (info.sampled && !std::binary_search(due.begin(), due.end(), info.group))) continue;
    wanted[i] = true;
    open.insert(open.end(), info.uses.begin(), info.uses.end());
  }
  OpList ops;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const CalculationInfo& info = calculations[i];
    if (!wanted[i] || (which == Which::kVarying && !info.varies) || (which == Which::kHeld && info.varies))
      continue;
    ops.push_back(info.op);
    ops.back().always = info.sampled;
  }
  return ops;
}

void Program::AppendSinks(const std::vector<const Source*>& sinks, OpList& ops) const {
  for (const Source* sink : sinks) {
    ops.push_back(calculations[sink->calculation_].op);
    ops.back().always = true;
  }
}

std::vector<std::uint32_t> Program::Downstream(std::vector<int> changed) const {
  std::set<std::uint32_t> found;
  while (!changed.empty()) {
    const int i = changed.back();
    changed.pop_back();
    for (const int next : calculations[i].affects) {
      if (calculations[next].sampled || !found.insert(static_cast<std::uint32_t>(next)).second) continue;
      changed.push_back(next);
    }
  }
  return {found.begin(), found.end()};
}

UpdatePlan Program::MakeUpdates(const std::vector<const Source*>& updates) const {
  UpdatePlan plan;
  if (updates.empty()) return plan;
  plan.ops = Needed(updates, Which::kAll);
  AppendSinks(updates, plan.ops);
  std::vector<int> changed;
  for (const Source* update : updates) {
    if (update->kind() == SourceKind::kPublish) continue;
    plan.commits.push_back({update->target_, update});
    plan.feeds |= calculations[update->calculation_].feeds;
    if (update->target_->kind() == SourceKind::kContinuous) {
      plan.changes_continuous = true;
    } else if (const auto found = readers.find(update->target_); found != readers.end()) {
      changed.insert(changed.end(), found->second.begin(), found->second.end());
    }
  }
  plan.invalidates = Downstream(changed);
  plan.invalidates.insert(plan.invalidates.end(), changed.begin(), changed.end());
  return plan;
}

TickPlan Program::MakeTick(const Groups& due) const {
  TickPlan plan;
  plan.groups = due;
  std::vector<const Source*> monitors, updates, publishes;
  std::vector<int> changed;
  // In the order of the blocks, whatever the order of the groups.
  for (const CalculationInfo& info : calculations) {
    if (!std::binary_search(due.begin(), due.end(), info.group)) continue;
    const Source* source = info.source;
    plan.feeds |= info.feeds;
    if (source->kind() == SourceKind::kOutput) {
      plan.due.push_back(source);
      changed.push_back(source->calculation_);
    }
    if (source->kind() == SourceKind::kMonitor) monitors.push_back(source);
    if (source->kind() == SourceKind::kUpdate) updates.push_back(source);
    if (source->kind() == SourceKind::kPublish) publishes.push_back(source);
  }
  for (const Source* source : plan.due) {
    if (!source->type_->fixed) plan.movable.push_back(source);
    for (const ScalarRun& run : source->type_->runs) {
      if (run.kind == ScalarKind::kDouble)
        plan.doubles.push_back({source->offset_ + run.offset, run.count, run.kind});
    }
  }
  plan.invalidates = Downstream(changed);
  publishes.insert(publishes.end(), plan.due.begin(), plan.due.end());
  plan.outputs = Needed(publishes, Which::kAll, due);
  plan.monitors = Needed(monitors, Which::kAll);
  AppendSinks(monitors, plan.monitors);
  plan.verdicts = monitors;
  plan.updates = MakeUpdates(updates);
  return plan;
}

OpList Program::Evaluation(const std::vector<const Source*>& sources) const {
  std::vector<const Source*> computed;
  for (const Source* source : sources) {
    if (source->calculation_ >= 0) computed.push_back(source);
  }
  OpList ops = Needed(computed, Which::kAll);
  for (const Source* source : computed) {
    const CalculationInfo& info = calculations[source->calculation_];
    if (!info.sampled) ops.push_back(info.op);
  }
  return ops;
}

}  // namespace tenon::internal
