#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/io/recording.h>

namespace tenon {

/// How long a calculation takes, and where it runs.
struct SlowOptions {
  double time = 0;        ///< duration of a calculation [s]; 0: its result is there at once
  double jitter = 0;      ///< durations are uniform in time ± jitter [s]
  bool measured = false;  ///< durations are those on this machine
  bool thread = false;    ///< in a thread of its own, for a run in real time; replaces the times above
  bool record = false;    ///< records the durations
  Recording<double> replay = {};  ///< if not empty, durations by time of start [s]; replaces all above
  Rate rate = Hz(1000);           ///< rate at which results are taken, a multiple of the block's

  static FieldList Fields() {
    using S = SlowOptions;
    return {Field("time_s", &S::time).Between(0, 10),
            Field("jitter_s", &S::jitter).AtLeast(0),
            {"measured", &S::measured},
            Undescribed(&S::thread),
            Undescribed(&S::record),
            Undescribed(&S::replay),
            Undescribed(&S::rate)};
  }
  void Validate() const {
    Demand(time >= jitter, "jitter must be from 0 to time: a calculation cannot end before it starts");
  }
  /// Whether anything differs from a block whose results are there at once.
  bool any() const { return time > 0 || measured || thread || !replay.empty(); }
};

template <class Block>
struct SlowParams {
  typename Block::Params block{};
  SlowOptions slow{};
  static FieldList Fields() { return {Undescribed(&SlowParams::block), {"slow", &SlowParams::slow}}; }
};

/// The result of the last finished calculation, and the time at which that one started [s].
template <class T>
struct SlowResult {
  T value = internal::Zeroed<T>();
  double start = 0;
  static FieldList Fields() { return {{"value", &SlowResult::value}, {"start", &SlowResult::start, "s"}}; }
};

/// The calculation that runs.
template <class T>
struct SlowJob {
  T pending = internal::Zeroed<T>();  ///< its result; in a thread, of the calculation before
  bool busy = false;
  bool in_thread = false;
  double start = 0;                  ///< [s]
  long left = 0;                     ///< ticks until the result is taken
  long taken = 0;                    ///< number of results taken
  double duration = 0;               ///< of the running calculation, if it is not in a thread [s]
  Recording<double> durations = {};  ///< of all calculations whose results were taken, if recorded [s]

  static FieldList Fields() {
    using S = SlowJob;
    return {{"pending", &S::pending},   {"busy", &S::busy},          {"in_thread", &S::in_thread},
            {"start", &S::start, "s"},  {"left", &S::left},          {"taken", &S::taken},
            {"duration", &S::duration}, {"durations", &S::durations}};
  }
};

namespace internal {

/// Runs the original calculation of a slow output, in the calling thread or in one of its own. A copy has no
/// thread and no calculation.
class SlowWorker {
 public:
  SlowWorker();
  SlowWorker(const SlowWorker&);
  SlowWorker& operator=(const SlowWorker&);
  ~SlowWorker();  ///< waits for the end of the calculation

  /// Calculates `*result`, which lies in the memory of the context.
  void Compute(void* result);
  /// Starts a calculation in the thread, with copies of the present inputs, at `time` [s]. `model` is a value
  /// of the result's type. Allocates only at the first call. Drops a calculation that was not taken.
  void Start(double time, const TypeInfo& type, const void* model);
  void Wait();                     ///< until the calculation has ended
  bool Holds(double start) const;  ///< whether the calculation that started then has not been taken
  bool done() const;               ///< whether it has ended
  void Take(void* result);         ///< copies the result; throws the error of the calculation
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Moves the calculation of `output` behind that of `result`: the calculation of `result`, whose third
/// argument is a SlowWorker, runs it, and `output` becomes a copy of the first member of the result.
void Defer(Source& output, Source& result);
/// The initial value of a source.
const void* ModelOf(const Source& source);
double Now();  ///< on a clock that never jumps [s]
/// Ticks of `slow.rate` per period of a slow output. Throws ParameterError for options that do not fit it.
long TicksPerPeriod(const Source& output, const SlowOptions& slow);

}  // namespace internal

/// A block with one sampled output whose calculation takes longer than a tick: a predictive controller, a
/// planner, a workspace.
///
///     auto& mpc = builder.Add<Slow<CdprMpc, &CdprMpc::plan>>(
///         "mpc", {.block = params, .slow = {.time = 0.004, .jitter = 0.001}});
///
/// It is the block itself, with the same ports, but this output changes when its calculation has ended. A
/// calculation starts at a tick of the block, unless the last one still runs, with the inputs of that tick.
/// Its result is taken at the first tick of `slow.rate` at which it is there:
///
///     output(t) = f(inputs(s)),   s the last start with s + duration <= t,   age = t - s
///
/// The first result is waited for, so that a run begins with one. All other calculations of the block run as
/// before, on the held output.
///
/// In simulation the duration is `time`, drawn uniformly from `time` ± `jitter`, or `measured` on this
/// machine. With `thread`, for a robot in real time, the calculation runs in a thread of its own. A run with
/// recorded durations as `replay` repeats a measured or threaded run bit for bit, if its inputs are the same:
///
///     context.Eval(mpc.job).durations
///
/// The tick neither waits, locks nor allocates after the first result: inputs and results are copied, and the
/// thread is woken by an atomic number. An exception of the calculation ends the run with a RunError that
/// names the block's `result`; out of a thread, at the tick at which the result would be taken. A clone or
/// snapshot continues bit for bit, but without a calculation that runs in a thread: it starts anew at the
/// next tick of the block. The destructor of a context waits for the thread.
///
/// `result` is the output with the start of its calculation, and `age` the time since then.
///
/// Throws ParameterError unless 0 <= jitter <= time, and `rate` is a multiple of the output's.
template <class Block, auto kOutput>
class Slow final : public Block {
  using T = typename std::remove_cvref_t<decltype(std::declval<Block&>().*kOutput)>::Value;
  using Job = SlowJob<T>;

 public:
  using Params = SlowParams<Block>;
  explicit Slow(Params p = {}) : Block(std::move(p.block)), slow(std::move(p.slow)) {
    internal::Defer(this->*kOutput, result);
  }

  const SlowOptions slow;

 private:
  const T& model_ = *static_cast<const T*>(internal::ModelOf(this->*kOutput));
  const long period_ = internal::TicksPerPeriod(this->*kOutput, slow);

 public:
  Random random{this, "duration"};
  Scratch<Job> job{this, "job", Job{.pending = model_}};
  Workspace<internal::SlowWorker> worker{this, "worker"};
  OutputPort<SlowResult<T>> result{this,
                                   {"result"},
                                   SlowResult<T>{model_},
                                   Sampled{slow.rate},
                                   Uses(this->time, job, worker, random),
                                   &Slow::CalcResult};
  OutputPort<double> age{this,
                         {"age", "s"},
                         Sampled{slow.rate},
                         Uses(this->time, result),
                         [](double t, const SlowResult<T>& last) { return t - last.start; }};

 private:
  void CalcResult(const double& t, Job& now, internal::SlowWorker& thread, RandomStream& stream,
                  SlowResult<T>* out) const {
    if (now.busy && now.in_thread && !thread.Holds(now.start)) now.busy = false;
    if (now.busy && (now.in_thread ? thread.done() : --now.left <= 0)) Take(t, now, thread, out);
    const bool first = now.taken == 0;
    if (now.busy || !IsDue(t, now)) return;
    now.busy = true;
    now.start = t;
    now.in_thread = slow.thread && slow.replay.empty();
    if (now.in_thread) {
      thread.Start(t, internal::TypeInfoOf<T>(), &model_);
      if (first) thread.Wait();
    } else {
      const auto begin = internal::Now();
      thread.Compute(&now.pending);
      now.duration = first ? 0 : Duration(internal::Now() - begin, now, stream);
      now.left = std::lround(std::ceil(now.duration / slow.rate.period() - 1e-6));
    }
    if (first || (!now.in_thread && now.left <= 0)) Take(t, now, thread, out);
  }
  void Take(double t, Job& now, internal::SlowWorker& thread, SlowResult<T>* out) const {
    if (now.in_thread) thread.Take(&now.pending);
    out->value = now.pending;
    out->start = now.start;
    now.busy = false;
    ++now.taken;
    if (slow.record) now.durations.push_back({now.start, now.in_thread ? t - now.start : now.duration});
  }
  bool IsDue(double t, const Job& now) const {
    const auto next = static_cast<std::size_t>(now.taken);
    if (!slow.replay.empty()) return next < slow.replay.size() && t >= slow.replay[next].time;
    return now.taken == 0 || std::lround(t / slow.rate.period()) % period_ == 0;
  }
  double Duration(double measured, const Job& now, RandomStream& stream) const {
    if (!slow.replay.empty()) return slow.replay[static_cast<std::size_t>(now.taken)].value;
    if (slow.measured) return measured;
    return slow.time + (slow.jitter > 0 ? slow.jitter * stream.Uniform(-1, 1) : 0);
  }
};

}  // namespace tenon
