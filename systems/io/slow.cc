#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/io/slow.h>

#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

namespace tenon::internal {
namespace {

constexpr std::size_t kOwn = 4;     // arguments of the calculation of Slow::result: time, job, worker, random
constexpr std::size_t kWorker = 2;  // index of the worker among them

std::size_t Entries(const std::vector<Slot>& slots) {
  std::size_t entries = 0;
  for (std::size_t i = 0; i < slots.size(); i += 1 + slots[i].count) ++entries;
  return entries;
}

}  // namespace

/// The calculation of Slow::result and the one that it runs. Their arguments are those of the latter, then
/// kOwn.
struct SlowFunction {
  using Held = std::unique_ptr<Closure, Closure::Delete>;
  Held closure, own;
  Thunk run, run_own;
  std::vector<Slot> slots;  ///< of the original calculation
};

struct SlowWorker::Impl {
  enum State { kIdle, kRuns, kDone, kEnds };

  /// An argument and its copy.
  struct Argument {
    const TypeInfo* type;
    std::size_t from, to;  ///< offsets in the context's memory, and in that of the copies
    enum { kInput, kMemory, kTool } kind;
  };

  ~Impl() {
    if (!thread.joinable()) return;
    state.exchange(kEnds);
    state.notify_one();
    thread.join();
    for (const Argument& argument : arguments) argument.type->destroy(copies + argument.to);
    result_type->destroy(copies + row_of_copies[0]);
    ::operator delete(copies, std::align_val_t(64));
  }

  void Run(Offset* with, std::byte* in) const {
    const Closure* closure = function->closure.get();
    std::size_t current = 0;
    function->run(&closure, with, in, 1, &current, kNoArgument);
  }
  void RunThread() {
    for (int now = state.load(); now != kEnds; now = state.load()) {
      if (now == kRuns) {
        try {
          Run(row_of_copies.data(), copies);
        } catch (...) {
          error = std::current_exception();
        }
        state.compare_exchange_strong(now, kDone);
        state.notify_one();
      } else {
        state.wait(now);
      }
    }
  }

  const SlowFunction* function = nullptr;
  std::byte* memory = nullptr;  ///< of the context
  std::vector<Offset> row;      ///< of the calculation, for that memory

  std::byte* copies = nullptr;
  std::vector<Offset> row_of_copies;
  std::vector<Argument> arguments;
  const TypeInfo* result_type = nullptr;
  double start = 0;          ///< of the calculation in the thread [s]
  std::exception_ptr error;  ///< of the calculation that has ended
  std::atomic<int> state = kIdle;
  std::thread thread;

  void Bind(const SlowFunction& to, std::byte* context, const Offset* whole);
  void MakeCopies(const TypeInfo& type, const void* model);
};

/// Copies the row of the original calculation, whose lists may lie behind the rows of others.
void SlowWorker::Impl::Bind(const SlowFunction& to, std::byte* context, const Offset* whole) {
  if (function != nullptr) return;
  function = &to;
  memory = context;
  row.assign(whole, whole + 1 + Entries(to.slots));
  for (std::size_t i = 0, entry = 1; i < to.slots.size(); i += 1 + to.slots[i].count, ++entry) {
    if (to.slots[i].what != Slot::What::kList) continue;
    const Offset* list = whole + whole[entry];
    row[entry] = static_cast<Offset>(row.size());
    row.insert(row.end(), list, list + 1 + to.slots[i].count);
  }
}

void SlowWorker::Impl::MakeCopies(const TypeInfo& type, const void* model) {
  std::size_t end = sizeof(double);
  const auto place = [&](const TypeInfo& of) {
    const std::size_t at = AlignUp(end, of.alignment);
    end = at + of.size;
    return static_cast<Offset>(at);
  };
  row_of_copies = row;
  row_of_copies[0] = place(type);
  const auto copy = [&](const Slot& slot, Offset& offset) {
    const TypeInfo& of = slot.source != nullptr ? slot.source->type() : TypeInfoOf<double>();
    const SourceKind kind = slot.source != nullptr ? slot.source->kind() : SourceKind::kInput;
    const bool kept = kind == SourceKind::kScratch || kind == SourceKind::kRandom;
    const Offset to = place(of);
    arguments.push_back({&of, offset, to,
                         kept                             ? Argument::kMemory
                         : kind == SourceKind::kWorkspace ? Argument::kTool
                                                          : Argument::kInput});
    offset = to;
  };
  const std::vector<Slot>& slots = function->slots;
  for (std::size_t i = 0, entry = 1; i < slots.size(); i += 1 + slots[i].count, ++entry) {
    if (slots[i].what != Slot::What::kList) {
      copy(slots[i], row_of_copies[entry]);
      continue;
    }
    for (std::size_t k = 1; k <= slots[i].count; ++k) copy(slots[i + k], row_of_copies[row[entry] + k]);
  }
  if (end > std::numeric_limits<Offset>::max()) throw RunError("the inputs of Slow take more than 4 GiB");
  copies = static_cast<std::byte*>(::operator new(end, std::align_val_t(64)));
  result_type = &type;
  type.copy_construct(copies + row_of_copies[0], model);
  for (const Argument& argument : arguments)
    argument.type->copy_construct(copies + argument.to, memory + argument.from);
  thread = std::thread([this] { RunThread(); });
}

SlowWorker::SlowWorker() : impl_(std::make_unique<Impl>()) {}
SlowWorker::SlowWorker(const SlowWorker&) : SlowWorker() {}
SlowWorker& SlowWorker::operator=(const SlowWorker&) {
  return *this;
}
SlowWorker::~SlowWorker() = default;

void SlowWorker::Compute(void* result) {
  impl_->row[0] = static_cast<Offset>(static_cast<std::byte*>(result) - impl_->memory);
  impl_->Run(impl_->row.data(), impl_->memory);
}

void SlowWorker::Start(double time, const TypeInfo& type, const void* model) {
  if (!impl_->thread.joinable()) impl_->MakeCopies(type, model);
  Wait();
  impl_->error = nullptr;
  impl_->start = time;
  for (const Impl::Argument& argument : impl_->arguments) {
    if (argument.kind != Impl::Argument::kTool)
      argument.type->assign(impl_->copies + argument.to, impl_->memory + argument.from);
  }
  impl_->state.store(Impl::kRuns);
  impl_->state.notify_one();
}

void SlowWorker::Wait() {
  impl_->state.wait(Impl::kRuns);
}
bool SlowWorker::Holds(double start) const {
  return impl_->state.load() != Impl::kIdle && impl_->start == start;
}
bool SlowWorker::done() const {
  return impl_->state.load() == Impl::kDone;
}

void SlowWorker::Take(void* result) {
  impl_->state.store(Impl::kIdle);
  if (impl_->error) std::rethrow_exception(std::exchange(impl_->error, nullptr));
  impl_->result_type->assign(result, impl_->copies + impl_->row_of_copies[0]);
  for (const Impl::Argument& argument : impl_->arguments) {
    if (argument.kind == Impl::Argument::kMemory)
      argument.type->assign(impl_->memory + argument.from, impl_->copies + argument.to);
  }
}

void Program::Defer(Source& output, Source& result) {
  SlowFunction function{std::move(output.closure_), std::move(result.closure_), output.run_, result.run_,
                        std::move(output.arguments_)};
  function.closure->calculation = &result;  // for messages about its arguments
  std::vector<Slot> arguments = function.slots;
  arguments.insert(arguments.end(), result.arguments_.begin(), result.arguments_.end());
  const Thunk run = [](const Closure* const* closures, const Offset* row, std::byte* memory,
                       std::size_t count, std::size_t* current, std::size_t) {
    for (std::size_t i = 0; i < count; ++i) {
      *current = i;
      const SlowFunction& slow = static_cast<const ClosureOf<SlowFunction>*>(closures[i])->function;
      const Offset* own = row + 1 + Entries(slow.slots);
      const std::array<Offset, 1 + kOwn> own_row{row[0], own[0], own[1], own[2], own[3]};
      std::launder(reinterpret_cast<SlowWorker*>(memory + own[kWorker]))->impl().Bind(slow, memory, row);
      const Closure* closure = slow.own.get();
      std::size_t index = 0;
      slow.run_own(&closure, own_row.data(), memory, 1, &index, kNoArgument);
      row = own + kOwn;
    }
  };
  result.SetCalculation(run, std::move(function), std::move(arguments));

  struct Copy {
    const TypeInfo* type;
  };
  const Thunk copy = [](const Closure* const* closures, const Offset* row, std::byte* memory,
                        std::size_t count, std::size_t* current, std::size_t) {
    for (std::size_t i = 0; i < count; ++i, row += 2) {
      *current = i;
      static_cast<const ClosureOf<Copy>*>(closures[i])
          ->function.type->assign(memory + row[0], memory + row[1]);
    }
  };
  output.SetCalculation(copy, Copy{output.type_}, {Slot{Slot::What::kSource, &result}});
  output.SetTrigger(result.trigger_);
}

const void* Program::ModelOf(const Source& source) {
  return source.model_;
}

void Defer(Source& output, Source& result) {
  Program::Defer(output, result);
}
const void* ModelOf(const Source& source) {
  return Program::ModelOf(source);
}

long TicksPerPeriod(const Source& output, const SlowOptions& slow) {
  CheckRanges(slow, "slow");
  slow.Validate();
  const Sampled& sampled = output.trigger().sampled;
  if (!output.is_sampled() || sampled.offset != 0)
    throw ParameterError(
        fmt::format("'{}' is not sampled without offset, as an output of Slow must be", output.name()));
  const double ticks = sampled.rate.period() / slow.rate.period();
  if (ticks < 0.5 || std::abs(ticks - std::round(ticks)) > 1e-9 * ticks)
    throw ParameterError(fmt::format("slow.rate = {} is not a multiple of {}, the rate of '{}'",
                                     ToString(slow.rate), ToString(sampled.rate), output.name()));
  return std::lround(ticks);
}

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace tenon::internal
