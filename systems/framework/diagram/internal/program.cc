#include <tenon/systems/framework/diagram/internal/program.h>

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

OpList Program::NeededWithSinks(const std::vector<const Source*>& sinks, Which which) const {
  OpList ops = Needed(sinks, which);
  std::vector<bool> listed(calculations.size());  // some witnesses are read by others
  for (const Op& op : ops) listed[op.calculation] = true;
  for (const Source* sink : sinks) {
    if (listed[static_cast<std::size_t>(sink->calculation_)]) continue;
    ops.push_back(calculations[sink->calculation_].op);
    ops.back().always = true;
  }
  return ops;
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

/// Appends the location of the numbers of `source`: doubles at fixed offsets, or a value to be inspected.
static void AppendNumbers(const Source& source, Offset offset, const TypeInfo& type,
                          std::vector<ScalarRun>* doubles, std::vector<const Source*>* inspected) {
  bool inspect = !type.fixed;
  for (const ScalarRun& run : type.runs) {
    if (run.kind == ScalarKind::kDouble) doubles->push_back({offset + run.offset, run.count, run.kind});
    if (run.kind == ScalarKind::kFloat) inspect = true;
  }
  if (inspect) inspected->push_back(&source);
}

UpdatePlan Program::MakeUpdates(const std::vector<const Source*>& updates) const {
  UpdatePlan plan;
  if (updates.empty()) return plan;
  plan.ops = NeededWithSinks(updates, Which::kAll);
  std::vector<int> changed;
  for (const Source* update : updates) {
    if (update->kind() == SourceKind::kPublish) continue;
    plan.commits.push_back({update->target_, update});
    AppendNumbers(*update, update->offset_, *update->type_, &plan.doubles, &plan.inspected);
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
  // Updates follow the order of the blocks, not of the groups.
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
    AppendNumbers(*source, source->offset_, *source->type_, &plan.doubles, &plan.inspected);
  }
  plan.invalidates = Downstream(changed);
  publishes.insert(publishes.end(), plan.due.begin(), plan.due.end());
  plan.outputs = Needed(publishes, Which::kAll, due);
  plan.monitors = NeededWithSinks(monitors, Which::kAll);
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

OpList Program::Gathered(const OpList& ops) const {
  constexpr std::uint32_t kOther = UINT32_MAX;
  std::vector<std::uint32_t> places(calculations.size(), kOther);  // index in `ops` of each calculation
  for (std::uint32_t i = 0; i < ops.size(); ++i) places[ops[i].calculation] = i;
  std::vector<int> awaited(ops.size(), 0);  // number of used values not computed yet
  std::unordered_map<Thunk, std::vector<std::uint32_t>> ready;
  for (std::uint32_t i = 0; i < ops.size(); ++i) {
    for (const int used : calculations[ops[i].calculation].uses) awaited[i] += places[used] != kOther;
    if (awaited[i] == 0) ready[ops[i].run].push_back(i);
  }
  OpList gathered;
  gathered.reserve(ops.size());
  std::vector<bool> done(ops.size(), false);
  for (std::uint32_t first = 0; first < ops.size(); ++first) {
    if (done[first]) continue;
    std::vector<std::uint32_t>& same = ready[ops[first].run];
    for (std::size_t k = 0; k < same.size(); ++k) {
      const Op& op = ops[same[k]];
      done[same[k]] = true;
      gathered.push_back(op);
      for (const int reader : calculations[op.calculation].affects) {
        const std::uint32_t place = places[reader];
        if (place != kOther && --awaited[place] == 0) ready[ops[place].run].push_back(place);
      }
    }
    same.clear();
  }
  return gathered;
}

BatchedOps Program::Batched(const OpList& ops) const {
  constexpr std::size_t kShortestChain = 4;
  BatchedOps list;
  list.ops = Gathered(ops);
  list.closures.reserve(ops.size());
  for (const Op& op : list.ops) list.closures.push_back(op.closure);
  std::vector<const Source*> sources;
  for (std::size_t begin = 0, end = 0; begin < list.ops.size(); begin = end) {
    const Thunk run = list.ops[begin].run;
    Chain chain = ChainFrom(list.ops, begin);
    end = chain.end;
    if (end - begin < kShortestChain) {  // not worth a chain: the batch ends before the next long one
      chain.carried = kNoArgument;
      for (end = begin + 1; end < list.ops.size() && list.ops[end].run == run; ++end) {
        if (ChainFrom(list.ops, end).end - end >= kShortestChain) break;
      }
    }
    list.batches.push_back({run, begin, end - begin, list.rows.size(), chain.carried});
    sources.clear();
    for (std::size_t i = begin; i < end; ++i) sources.push_back(calculations[list.ops[i].calculation].source);
    AppendRows(sources, list.rows);
  }
  return list;
}

Program::Chain Program::ChainFrom(const OpList& ops, std::size_t begin) const {
  Chain chain{begin + 1, kNoArgument};
  for (; chain.end < ops.size() && ops[chain.end].run == ops[begin].run; ++chain.end) {
    const std::size_t argument = ArgumentFrom(ops[chain.end - 1], ops[chain.end]);
    if (argument == kNoArgument) break;
    if (chain.carried == kNoArgument) chain.carried = argument;
    if (argument != chain.carried) break;
  }
  return chain;
}

std::size_t Program::ArgumentFrom(const Op& op, const Op& next) const {
  const std::vector<Slot>& slots = calculations[next.calculation].source->arguments_;
  std::size_t argument = 0;
  for (std::size_t i = 0; i < slots.size(); ++i, ++argument) {
    const Source* source = slots[i].source;
    if (source != nullptr && source->calculation_ == static_cast<int>(op.calculation)) return argument;
    i += slots[i].count;  // entries of a list
  }
  return kNoArgument;
}

void Program::AppendRows(std::span<const Source* const> sources, std::vector<Offset>& rows) {
  const auto place = [](const Slot& slot) {
    return slot.source != nullptr ? slot.source->offset_ : Offset{0};  // time has offset 0
  };
  std::size_t row = rows.size();
  for (const Source* source : sources) {
    rows.push_back(source->offset_);
    const std::vector<Slot>& slots = source->arguments_;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      rows.push_back(place(slots[i]));
      i += slots[i].count;  // entries of a list
    }
  }
  for (const Source* source : sources) {
    const std::vector<Slot>& slots = source->arguments_;
    std::size_t entry = row + 1;
    for (std::size_t i = 0; i < slots.size(); ++i, ++entry) {
      if (slots[i].what != Slot::What::kList) continue;
      rows[entry] = static_cast<Offset>(rows.size() - row);
      rows.push_back(slots[i].count);
      for (const std::size_t end = i + slots[i].count; i < end;) rows.push_back(place(slots[++i]));
    }
    row = entry;
  }
}

}  // namespace tenon::internal
