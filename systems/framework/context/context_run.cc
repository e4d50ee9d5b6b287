#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/context/internal/profiler.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <fmt/core.h>

#include <exception>

namespace tenon {

using internal::CalculationInfo;
using internal::Finiteness;
using internal::Op;

namespace {

/// memcpy requires valid pointers even for size 0, which an empty vector does not have.
void CopyScalars(void* to, const void* from, std::size_t count) {
  if (count > 0) std::memcpy(to, from, count * sizeof(double));
}

}  // namespace

bool Context::IsFresh(const Op& op) const {
  return op.varies ? stamps_[op.calculation] == instant_ : stamps_[op.calculation] != 0;
}

void Context::SetRunTime(double time) {
  *reinterpret_cast<double*>(memory_.get()) = time;
  ++instant_;
}

double* Context::continuous_data() {
  return reinterpret_cast<double*>(memory_.get() + diagram_->program().continuous_begin);
}
double* Context::derivative_data() {
  return reinterpret_cast<double*>(memory_.get() + diagram_->program().derivative_begin);
}

void Context::LoadStates(const double* x) {
  const internal::Program& program = diagram_->program();
  double* states = continuous_data();
  if (states != x) CopyScalars(states, x, static_cast<std::size_t>(program.num_continuous));
  if (!program.unpacked_states.empty()) UnpackStates();
}

void Context::UnpackStates() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_states) {
    CopyScalars(each.source->type_->data(memory_.get() + each.source->offset_), memory_.get() + each.offset,
                each.count);
  }
}

void Context::PackStates() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_states) {
    CopyScalars(memory_.get() + each.offset, each.source->type_->data(memory_.get() + each.source->offset_),
                each.count);
  }
}

void Context::PackDerivatives() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_derivatives) {
    std::byte* value = memory_.get() + each.source->offset_;
    if (const std::size_t size = internal::CountScalars(*each.source->type_, value); size != each.count) {
      throw RunError(fmt::format("'{}' has {} elements, but its state has {}: make them equal",
                                 each.source->path(), size, each.count));
    }
    CopyScalars(memory_.get() + each.offset, each.source->type_->data(value), each.count);
  }
}

void Context::CalcRunDerivatives(double t, const double* x, double* xdot) {
  const internal::Program& program = diagram_->program();
  LoadStates(x);
  SetRunTime(t);
  RunAll(program.derivatives);
  if (!program.unpacked_derivatives.empty()) PackDerivatives();
  ++instant_;  // RunAll leaves no stamps, so nothing counts as fresh
  CopyScalars(xdot, derivative_data(), static_cast<std::size_t>(program.num_continuous));
}

inline void Context::Run(const Op& op) {
  std::size_t current = 0;
  op.run(&op.closure, op.row, memory_.get(), 1, &current, internal::kNoArgument);
}

inline void Context::Run(const internal::BatchedOps& list, const internal::Batch& batch) {
  std::size_t current = 0;
  try {
    batch.run(list.closures.data() + batch.begin, list.rows.data() + batch.rows, memory_.get(), batch.count,
              &current, batch.carried);
  } catch (...) {
    RethrowFrom(list.ops[batch.begin + current]);
  }
}

void Context::RunAll(const internal::BatchedOps& list) {
  if (profiler_ != nullptr) return RunProfiled(list.ops, true);
  for (const internal::Batch& batch : list.batches) Run(list, batch);
}

void Context::RunStale(const internal::BatchedOps& list) {
  if (profiler_ != nullptr) return RunProfiled(list.ops, false);
  for (const internal::Batch& batch : list.batches) {
    const std::span ops(list.ops.data() + batch.begin, batch.count);
    if (std::any_of(ops.begin(), ops.end(), [&](const Op& op) { return !op.always && IsFresh(op); })) {
      RunStale(ops);
      continue;
    }
    Run(list, batch);
    for (const Op& op : ops) stamps_[op.calculation] = instant_;
  }
}

void Context::RunStale(std::span<const Op> ops) {
  if (profiler_ != nullptr) return RunProfiled(ops, false);
  const Op* op = ops.data();
  const Op* const end = op + ops.size();
  try {
    for (; op != end; ++op) {
      if (!op->always && IsFresh(*op)) continue;
      Run(*op);
      stamps_[op->calculation] = instant_;
    }
  } catch (...) {
    RethrowFrom(*op);
  }
}

/// RunAll and RunStale with a profiler.
void Context::RunProfiled(std::span<const Op> ops, bool all) {
  const std::size_t before = profiler_->current();
  for (const Op& op : ops) {
    if (!all && !op.always && IsFresh(op)) continue;
    profiler_->Enter(internal::Profiler::kCalculations + op.calculation);
    try {
      Run(op);
    } catch (...) {
      RethrowFrom(op);
    }
    if (!all) stamps_[op.calculation] = instant_;
  }
  if (profiler_->current() != before) profiler_->Enter(before);
}

void Context::RethrowFrom(const Op& op) const {
  const Source& source = *diagram_->program().calculations[op.calculation].source;
  try {
    throw;
  } catch (const std::exception& error) {
    std::throw_with_nested(
        RunError(fmt::format("'{}' failed at t = {} s: {}", source.path(), time(), error.what()),
                 source.owner().path()));
  } catch (...) {
    std::throw_with_nested(
        RunError(fmt::format("'{}' failed at t = {} s: it threw an object that is not a std::exception",
                             source.path(), time()),
                 source.owner().path()));
  }
}

void Context::Invalidate(const std::vector<std::uint32_t>& calculations) {
  for (const std::uint32_t i : calculations) stamps_[i] = 0;
}

void Context::ReadWitnesses(double* values) const {
  for (const internal::WitnessPlan& plan : diagram_->program().witness_plans) {
    const std::byte* address = Address(*plan.witness);
    // Pieces are small integers, which a double represents exactly.
    *values = plan.is_kink ? static_cast<double>(*reinterpret_cast<const std::int64_t*>(address))
                           : *reinterpret_cast<const double*>(address);
    if (std::isnan(*values)) {
      throw RunError(
          fmt::format("witness '{}' is nan at t = {} s and can never cross zero: check its function and "
                      "the values that it uses",
                      plan.witness->path(), time()),
          plan.witness->owner().path());
    }
    ++values;
  }
}

/// Throws RunError for a NaN in any new state, or an infinity in a continuous state.
void Context::CheckUpdates(const internal::UpdatePlan& plan) const {
  if (!checks_values_ || (internal::AllFinite(memory_.get(), plan.doubles) && plan.inspected.empty())) return;
  for (const internal::Commit& commit : plan.commits) {
    const Finiteness found = internal::FinitenessOf(*commit.next->type_, Address(*commit.next));
    const bool integrated = commit.state->kind() == SourceKind::kContinuous;
    if (found == Finiteness::kNan || (integrated && found != Finiteness::kFinite)) {
      throw RunError(
          fmt::format("state {} at t = {} s after its update: correct the update or the values that it uses",
                      DescribeNonFinite(*commit.state, *commit.next), time()),
          commit.state->owner().path());
    }
  }
}

void Context::Apply(const internal::UpdatePlan& plan) {
  if (plan.empty()) return;
  RunStale(plan.ops);
  CheckUpdates(plan);
  for (const internal::Commit& commit : plan.commits) {
    commit.state->type_->assign(memory_.get() + commit.state->offset_, memory_.get() + commit.next->offset_);
  }
  Invalidate(plan.invalidates);
  if (plan.changes_continuous) {
    PackStates();
    ++instant_;
  }
}

void Context::Mute(const Source& publish, bool muted) {
  reinterpret_cast<internal::Published*>(memory_.get() + publish.offset_)->muted = muted;
}

std::string Context::DescribeNonFinite(const Source& source, const Source& holder) const {
  const void* value = Address(holder);
  const std::vector<Element> elements = internal::ListElements(*source.type_, value, source.spec());
  const std::vector<double> doubles = internal::DoublesOf(*source.type_, value);
  // Report a NaN before an infinity, which is legitimate in a bound.
  for (const bool nan : {true, false}) {
    for (std::size_t i = 0; i < doubles.size(); ++i) {
      if (nan ? !std::isnan(doubles[i]) : !std::isinf(doubles[i])) continue;
      return fmt::format("'{}' is {}", elements[i].PathIn(source.path()), doubles[i]);
    }
  }
  return "";
}

std::string Context::DescribeNonFinite() const {
  const internal::Program& program = diagram_->program();
  std::vector<const Source*> sources = program.continuous;
  sources.insert(sources.end(), program.open_inputs.begin(), program.open_inputs.end());
  for (const CalculationInfo& info : program.calculations) {
    const SourceKind kind = info.source->kind();
    if (kind != SourceKind::kUpdate && kind != SourceKind::kMonitor && kind != SourceKind::kPublish &&
        kind != SourceKind::kNextJump)
      sources.push_back(info.source);
  }
  // Report a NaN before an infinity: infinite bounds are legitimate.
  for (const Finiteness sought : {Finiteness::kNan, Finiteness::kInfinite}) {
    for (const Source* source : sources) {
      if (internal::FinitenessOf(*source->type_, Address(*source)) == sought)
        return DescribeNonFinite(*source, *source);
    }
  }
  return "";
}

}  // namespace tenon
