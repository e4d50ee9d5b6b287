#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/context/internal/profiler.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <exception>

namespace tenon {

using internal::CalculationInfo;
using internal::Cell;
using internal::Finiteness;
using internal::Op;

namespace {

/// A copy of a value whose type is known at run time only.
class Copy {
 public:
  Copy(const internal::TypeInfo& type, const void* model)
      : type_(type), memory_(::operator new(type.size, std::align_val_t(type.alignment))) {
    type.copy_construct(memory_, model);
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  ~Copy() {
    type_.destroy(memory_);
    ::operator delete(memory_, std::align_val_t(type_.alignment));
  }
  void* get() const { return memory_; }

 private:
  const internal::TypeInfo& type_;
  void* memory_;
};

/// Throws ParameterError if a matrix would change its size: values computed from
/// it have fixed sizes.
void CheckSize(const std::string& path, const internal::TypeInfo& type, const void* present,
               const void* value) {
  if (type.kind != internal::TypeInfo::Kind::kMatrix || (type.rows >= 0 && type.cols >= 0)) return;
  std::size_t rows = 0, cols = 0, given_rows = 0, given_cols = 0;
  type.shape(present, &rows, &cols);
  type.shape(value, &given_rows, &given_cols);
  if (rows == given_rows && cols == given_cols) return;
  throw ParameterError(
      fmt::format("parameter '{}' is {} x {}, but the value is {} x {}: its size cannot change", path, rows,
                  cols, given_rows, given_cols));
}

}  // namespace

std::unique_ptr<Context> Diagram::CreateContext(std::uint64_t seed) const {
  return std::unique_ptr<Context>(new Context(shared_from_this(), seed));
}

Context::Context(std::shared_ptr<const Diagram> diagram, std::uint64_t seed)
    : diagram_(std::move(diagram)), seed_(seed) {
  const internal::Program& program = diagram_->program();
  memory_.reset(static_cast<std::byte*>(::operator new(program.memory_size, std::align_val_t(64))));
  std::memset(memory_.get(), 0, program.memory_size);
  for (const Cell& cell : program.cells) {
    const Source& source = *cell.source;
    source.type_->copy_construct(memory_.get() + cell.offset, source.model_);
    if (source.kind() == SourceKind::kRandom) {
      new (memory_.get() + cell.offset) RandomStream(seed, source.path());
    }
  }
  stamps_.assign(program.calculations.size(), 0);
  fixed_.assign(program.open_inputs.size(), false);
  PackStates();
  MarkAllStale();
}

Context::~Context() {
  if (!memory_) return;
  for (const Cell& cell : diagram_->program().objects)
    cell.source->type_->destroy(memory_.get() + cell.offset);
}

std::unique_ptr<Context> Context::Clone() const {
  const internal::Program& program = diagram_->program();
  // The public constructor would make initial values only to overwrite them.
  std::unique_ptr<Context> clone(new Context(*this, program));
  return clone;
}

Context::Context(const Context& other, const internal::Program& program)
    : diagram_(other.diagram_),
      memory_(static_cast<std::byte*>(::operator new(program.memory_size, std::align_val_t(64)))),
      seed_(other.seed_),
      stamps_(other.stamps_),
      instant_(other.instant_),
      fixed_(other.fixed_),
      progress_(other.progress_),
      failure_(other.failure_),
      next_step_(other.next_step_),
      last_error_(other.last_error_),
      witness_memory_(other.witness_memory_),
      step_start_(other.step_start_) {
  std::memcpy(memory_.get(), other.memory_.get(), program.memory_size);  // all but the objects, copied next
  for (const Cell& cell : program.objects) {
    const Source& source = *cell.source;
    const bool own = source.kind() == SourceKind::kWorkspace;
    source.type_->copy_construct(memory_.get() + cell.offset,
                                 own ? source.model_ : other.memory_.get() + cell.offset);
  }
}

void Context::CheckOwned(const Source& source) const {
  if (const std::string fault = internal::DescribeReplacement(source); !fault.empty()) throw RunError(fault);
  const System* top = &source.owner();
  while (top->parent() != nullptr) top = top->parent();
  for (const auto& block : diagram_->blocks()) {
    if (block.get() == top) return;
  }
  throw RunError(
      fmt::format("'{}' is not part of this context's diagram: use ports of the blocks that were "
                  "added to its builder",
                  source.path()));
}

void Context::CheckReadable(const Source& source) const {
  CheckOwned(source);
  if (source.kind() == SourceKind::kPublish)
    throw RunError(
        fmt::format("'{}' is a side effect and has no value: read the ports that it uses", source.path()));
}

const std::byte* Context::Address(const Source& source) const {
  return memory_.get() + source.offset_;
}

const void* Context::EvalAddress(const Source& source) {
  CheckReadable(source);
  if (source.calculation_ >= 0) {
    EnsureFresh(source.calculation_);
  } else {
    CheckFixed(source.Resolve());
  }
  return Address(source);
}

bool Context::IsKnown(const Source& source) const {
  CheckReadable(source);
  if (source.calculation_ < 0) {
    CheckFixed(source.Resolve());
    return true;
  }
  return IsFresh(diagram_->program().calculations[source.calculation_].op);
}

/// The numbers that a source holds, whether fresh or stale.
std::vector<double> Context::HeldNumbers(const Source& source) const {
  const void* value = Address(source);
  std::vector<double> doubles(internal::CountScalars(*source.type_, value));
  internal::ToDoubles(*source.type_, value, doubles.data());
  return doubles;
}

std::vector<double> Context::EvalDoubles(const Source& source) {
  EvalAddress(source);
  return HeldNumbers(source);
}

std::vector<Element> Context::Elements(const Source& source) const {
  CheckOwned(source);
  return internal::ListElements(*source.type_, Address(source), source.spec_);
}

void Context::CheckSettable(const Source& source) const {
  CheckOwned(source);
  const Source& origin = source.Resolve();
  if (source.kind() == SourceKind::kInput && origin.kind() != SourceKind::kInput) {
    throw RunError(fmt::format(
        "input '{}' is connected to '{}': set that source or its prerequisites, or build the diagram "
        "without the connection",
        source.path(), origin.path()));
  }
  if (origin.calculation_ >= 0 && !diagram_->program().calculations[origin.calculation_].sampled) {
    throw RunError(
        fmt::format("'{}' is computed: set the states and inputs that it depends on instead", source.path()));
  }
}

void* Context::MutableAddress(const Source& source) {
  CheckSettable(source);
  const Source& origin = source.Resolve();
  MarkAllStale(source.kind() == SourceKind::kParameter);
  if (origin.calculation_ >= 0) stamps_[origin.calculation_] = 1;
  const auto& open = diagram_->program().open_inputs;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (open[i] == &origin) fixed_[i] = true;
  }
  return memory_.get() + origin.offset_;
}

void Context::SetDoubles(const Source& source, std::span<const double> values) {
  CheckSettable(source);
  const internal::TypeInfo& type = *source.type_;
  const std::size_t size = internal::CountScalars(type, Address(source));
  if (size != values.size()) {
    throw RunError(
        fmt::format("'{}' has {} elements, but {} values are given", source.path(), size, values.size()));
  }
  const Copy value(type, Address(source));
  try {
    internal::FromDoubles(type, value.get(), values.data());
  } catch (const internal::NumberError& error) {
    throw ParameterError(fmt::format("'{}': {}", source.path(), error.what()));
  }
  Assign({&source, value.get()});
}

void Context::Assign(const Assignment& assignment) {
  const Source& source = *assignment.source;
  if (source.kind() == SourceKind::kParameter) return AssignParameters({&assignment, 1});
  CheckSettable(source);
  if (source.kind() == SourceKind::kContinuous) {
    const std::size_t size = internal::CountScalars(*source.type_, Address(source)),
                      given = internal::CountScalars(*source.type_, assignment.value);
    if (size != given) {
      throw RunError(fmt::format("state '{}' has {} elements, but the value has {}: its size cannot change",
                                 source.path(), size, given));
    }
  }
  source.type_->assign(MutableAddress(source), assignment.value);
  PackStates();
}

void Context::AssignParameters(std::span<const Assignment> list) {
  for (const Assignment& each : list) {
    CheckOwned(*each.source);
    if (internal::FinitenessOf(*each.source->type_, each.value) == internal::Finiteness::kNan) {
      throw ParameterError(fmt::format("parameter '{}' cannot be set to NaN", each.source->path()));
    }
    CheckSize(each.source->path(), *each.source->type_, Address(*each.source), each.value);
  }
  for (const Assignment& each : list) {
    const System& block = each.source->owner();
    internal::ParameterValues values;
    for (const Source* source : block.sources()) {
      if (source->kind() != SourceKind::kParameter) continue;
      const auto& parameter = static_cast<const internal::ParameterSource&>(*source);
      if (parameter.offset_in_params_ == internal::ParameterSource::kNone) continue;
      const void* value = Address(parameter);
      for (const Assignment& other : list) {
        if (other.source == source) value = other.value;
      }
      values.Add({parameter.type_, parameter.offset_in_params_, value});
    }
    try {
      static_cast<const Leaf&>(block).ValidateParameters(values);
    } catch (const ParameterError& error) {
      std::throw_with_nested(
          ParameterError(fmt::format("parameter '{}' cannot be set: {}", each.source->path(), error.what())));
    }
  }
  for (const Assignment& each : list) each.source->type_->assign(MutableAddress(*each.source), each.value);
}

void Context::CheckFixed(const Source& origin) const {
  const auto& open = diagram_->program().open_inputs;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (open[i] != &origin || fixed_[i]) continue;
    throw RunError(fmt::format(
        "input '{}' is not connected and has no value: connect it, or set it before the first evaluation",
        origin.path()));
  }
}

void Context::CheckAllFixed() const {
  for (const Source* input : diagram_->program().open_inputs) CheckFixed(*input);
}

void Context::CheckSample(const CalculationInfo& sampled) const {
  if (stamps_[sampled.op.calculation] != 0) return;
  throw RunError(
      fmt::format("sampled output '{}' is read at t = {} s before it has run: initialise the simulator, "
                  "step the block, or declare an initial value",
                  sampled.source->path(), time()));
}

void Context::CheckSamplesFor(const internal::OpList& ops) const {
  const auto& calculations = diagram_->program().calculations;
  for (const Op& op : ops) {
    for (const int used : calculations[op.calculation].uses) {
      if (calculations[used].sampled) CheckSample(calculations[used]);
    }
  }
}

void Context::EnsureFresh(int calculation) {
  const CalculationInfo& info = diagram_->program().calculations[calculation];
  if (IsFresh(info.op)) return;
  if (info.sampled) CheckSample(info);
  for (const internal::Slot& slot : info.source->arguments_) {
    if (slot.source != nullptr && slot.source->calculation_ < 0) CheckFixed(slot.source->Resolve());
  }
  for (const int used : info.uses) EnsureFresh(used);
  Op op = info.op;
  op.always = true;
  RunStale(std::span(&op, 1));
}

bool Context::IsFresh(const Op& op) const {
  return op.varies ? stamps_[op.calculation] == instant_ : stamps_[op.calculation] != 0;
}

/// Marks every computed value stale after a change from outside the run.
void Context::MarkAllStale(bool settled) {
  ++edition_;
  step_start_.valid = false;
  witness_memory_.clear();
  const auto& calculations = diagram_->program().calculations;
  for (std::size_t i = 0; i < calculations.size(); ++i) {
    const Source& source = *calculations[i].source;
    const bool held = calculations[i].sampled && (stamps_[i] != 0 || source.has_initial_value_);
    const bool keeps = calculations[i].settled && !settled && stamps_[i] != 0;
    stamps_[i] = held || keeps ? 1 : 0;
  }
  ++instant_;
}

void Context::SetTime(double time) {
  SetRunTime(time);
  MarkAllStale();
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
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(program.num_continuous);
  double* states = continuous_data();
  if (states != x && bytes > 0) std::memcpy(states, x, bytes);
  if (!program.unpacked_states.empty()) UnpackStates();
}

void Context::UnpackStates() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_states) {
    std::memcpy(each.source->type_->data(memory_.get() + each.source->offset_), memory_.get() + each.offset,
                each.count * sizeof(double));
  }
}

void Context::PackStates() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_states) {
    std::memcpy(memory_.get() + each.offset, each.source->type_->data(memory_.get() + each.source->offset_),
                each.count * sizeof(double));
  }
}

void Context::PackDerivatives() {
  for (const internal::Unpacked& each : diagram_->program().unpacked_derivatives) {
    std::byte* value = memory_.get() + each.source->offset_;
    if (const std::size_t size = internal::CountScalars(*each.source->type_, value); size != each.count) {
      throw RunError(fmt::format("'{}' has {} elements, but its state has {}: make them equal",
                                 each.source->path(), size, each.count));
    }
    std::memcpy(memory_.get() + each.offset, each.source->type_->data(value), each.count * sizeof(double));
  }
}

Eigen::Map<const Eigen::VectorXd> Context::continuous_state() const {
  const internal::Program& program = diagram_->program();
  return {reinterpret_cast<const double*>(memory_.get() + program.continuous_begin), program.num_continuous};
}

void Context::SetContinuousState(const Eigen::Ref<const Eigen::VectorXd>& state) {
  if (state.size() != diagram_->num_continuous_states()) {
    throw RunError(fmt::format("the diagram has {} continuous states, but {} values are given",
                               diagram_->num_continuous_states(), state.size()));
  }
  LoadStates(state.data());
  MarkAllStale();
}

Eigen::VectorXd Context::EvalTimeDerivatives() {
  const internal::Program& program = diagram_->program();
  CheckAllFixed();
  CheckSamplesFor(program.held);
  CheckSamplesFor(program.derivatives.ops);
  RunStale(program.held);
  RunStale(program.derivatives);
  PackDerivatives();
  return Eigen::Map<const Eigen::VectorXd>(derivative_data(), diagram_->num_continuous_states());
}

void Context::CalcTimeDerivatives(double t, const double* x, double* xdot) {
  ++edition_;
  step_start_.valid = false;
  witness_memory_.clear();
  CalcRunDerivatives(t, x, xdot);
}

void Context::CalcRunDerivatives(double t, const double* x, double* xdot) {
  const internal::Program& program = diagram_->program();
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(program.num_continuous);
  LoadStates(x);
  SetRunTime(t);
  RunAll(program.derivatives);
  if (!program.unpacked_derivatives.empty()) PackDerivatives();
  ++instant_;  // RunAll leaves no stamps, so nothing counts as fresh
  if (bytes > 0) std::memcpy(xdot, derivative_data(), bytes);
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
        RunError(fmt::format("'{}' failed at t = {} s: {}", source.path(), time(), error.what())));
  } catch (...) {
    std::throw_with_nested(RunError(fmt::format(
        "'{}' failed at t = {} s: it threw an object that is not a std::exception", source.path(), time())));
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
                      plan.witness->path(), time()));
    }
    ++values;
  }
}

/// Throws RunError for a NaN in any new state, or an infinity in a continuous state.
void Context::CheckUpdates(const internal::UpdatePlan& plan) const {
  if (!checks_values_ || (internal::AllFinite(memory_.get(), plan.doubles) && plan.movable.empty())) return;
  for (const internal::Commit& commit : plan.commits) {
    const Finiteness found = internal::FinitenessOf(*commit.next->type_, Address(*commit.next));
    const bool integrated = commit.state->kind() == SourceKind::kContinuous;
    if (found == Finiteness::kNan || (integrated && found != Finiteness::kFinite)) {
      throw RunError(
          fmt::format("state {} at t = {} s after its update: correct the update or the values that it uses",
                      DescribeNonFinite(*commit.state, *commit.next), time()));
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
  std::vector<double> doubles(elements.size());
  internal::ToDoubles(*source.type_, value, doubles.data());
  // Report a NaN before an infinity, which is legitimate in a bound.
  for (const bool nan : {true, false}) {
    for (std::size_t i = 0; i < doubles.size(); ++i) {
      if (nan ? !std::isnan(doubles[i]) : !std::isinf(doubles[i])) continue;
      const std::string element = elements[i].name.empty() ? "" : "." + elements[i].name;
      return fmt::format("'{}{}' is {}", source.path(), element, doubles[i]);
    }
  }
  return "";
}

std::string Context::DescribeNonFinite() const {
  const internal::Program& program = diagram_->program();
  const auto describe = [&](const Source& source) { return DescribeNonFinite(source, source); };
  // Report a NaN before an infinity: infinite bounds are legitimate.
  for (const Finiteness sought : {Finiteness::kNan, Finiteness::kInfinite}) {
    for (const Source* state : program.continuous) {
      if (internal::FinitenessOf(*state->type_, Address(*state)) == sought) return describe(*state);
    }
    for (const Source* input : program.open_inputs) {
      if (internal::FinitenessOf(*input->type_, Address(*input)) == sought) return describe(*input);
    }
    for (const CalculationInfo& info : program.calculations) {
      const Source& source = *info.source;
      if (source.kind() == SourceKind::kUpdate || source.kind() == SourceKind::kMonitor ||
          source.kind() == SourceKind::kPublish || source.kind() == SourceKind::kNextJump) {
        continue;
      }
      if (internal::FinitenessOf(*source.type_, Address(source)) == sought) return describe(source);
    }
  }
  return "";
}

}  // namespace tenon
