#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <fmt/core.h>

#include <exception>

namespace tenon {

using internal::CalculationInfo;
using internal::Cell;
using internal::Op;

namespace {

/// Throws ParameterError if a matrix would change its size: values computed from it have
/// fixed sizes.
void CheckSize(const std::string& path, const internal::TypeInfo& type, const void* present,
               const void* value) {
  if (type.kind != internal::TypeInfo::Kind::kMatrix || (type.rows >= 0 && type.cols >= 0)) return;
  const internal::Extents shape = internal::ExtentsOf(type, present),
                          given = internal::ExtentsOf(type, value);
  if (shape == given) return;
  throw ParameterError(
      fmt::format("parameter '{}' is {} x {}, but the value is {} x {}: its size cannot change", path,
                  shape.rows, shape.cols, given.rows, given.cols));
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
      time_rest_(other.time_rest_),
      begin_time_(other.begin_time_),
      next_step_(other.next_step_),
      last_error_(other.last_error_),
      witness_memory_(other.witness_memory_),
      event_memory_(other.event_memory_),
      num_steps_(other.num_steps_),
      movement_(other.movement_),
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
  const System* top = &source.Current().owner();
  while (top->parent() != nullptr) top = top->parent();
  for (const auto& block : diagram_->blocks()) {
    if (block.get() == top) return;
  }
  throw RunError(fmt::format(
      "'{}' is not part of this context's diagram: use ports of the blocks that were added to its builder",
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
  return internal::DoublesOf(*source.type_, Address(source));
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
  const internal::AnyValue value(type, Address(source));
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
  CheckDeclaredSize(source, assignment.value);
  source.type_->assign(MutableAddress(source), assignment.value);
  PackStates();
}

/// Throws RunError if a matrix of run-time size has another size than its source, or a port that reads it,
/// declares.
void Context::CheckDeclaredSize(const Source& source, const void* value) const {
  const Source* declares = source.Resolve().declares_size_;
  if (declares == nullptr || source.kind() == SourceKind::kContinuous) return;
  const internal::Extents declared = internal::ExtentsOf(*declares->type_, declares->model_),
                          given = internal::ExtentsOf(*declares->type_, value);
  if (declared == given) return;
  throw RunError(fmt::format("'{}' cannot be set to {} x {} elements, because '{}' is declared with {} x {}",
                             source.path(), given.rows, given.cols, declares->path(), declared.rows,
                             declared.cols));
}

void Context::AssignParameters(std::span<const Assignment> given) {
  std::vector<Assignment> list(given.begin(), given.end());
  for (Assignment& each : list) {
    CheckOwned(*each.source);
    each.source = &each.source->Current();  // its block has the limits
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
      static_cast<const internal::ParameterSource&>(*each.source).Check(each.value);
      static_cast<const Leaf&>(block).ValidateParameters(values);
    } catch (const ParameterError& error) {
      std::throw_with_nested(ParameterError(
          fmt::format("parameter '{}' cannot be set: {}", each.source->path(), error.what()), block.path()));
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

void Context::ForgetRun() {
  ++edition_;
  step_start_.valid = false;
  witness_memory_.clear();
  event_memory_.clear();
  num_steps_ = movement_ = 0;
}

/// Marks every computed value stale after a change from outside the run.
void Context::MarkAllStale(bool settled) {
  ForgetRun();
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
  if (!std::isfinite(time))
    throw RunError(fmt::format("cannot set the time to {} s: give a finite time", time));
  SetRunTime(time);
  time_rest_ = 0;
  begin_time_ = time;
  MarkAllStale();
  next_step_ = last_error_ = 0;
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
  ForgetRun();
  time_rest_ = 0;
  CalcRunDerivatives(t, x, xdot);
}

}  // namespace tenon
