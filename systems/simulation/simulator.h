#pragma once

#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/simulation/run_profile.h>
#include <tenon/systems/simulation/signal_log.h>
#include <tenon/systems/simulation/simulator_options.h>

#include <exception>

namespace tenon {

class SundialsIntegrator;

namespace internal {
class EventFinder;
class Profiler;
class Schedule;
struct UpdatePlan;
}  // namespace internal

/// How an advance ended.
struct RunStatus {
  double time = 0;                  ///< [s]
  bool ended = false;               ///< a monitor ended the run
  std::string reason;               ///< the monitor's reason, preceded by its path
  const Source* monitor = nullptr;  ///< the monitor; null if it was added by AddMonitor
};

/// Runs a diagram. It integrates between the ticks that affect a derivative. At each tick it computes all due
/// sampled outputs in dataflow order, writes the logs, evaluates the termination conditions (monitors), and
/// applies all due updates at once.
///
///     Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
///     simulator.RunTo(5);
///     simulator.context().Eval(cart.state);
class Simulator {
 public:
  /// Creates its own context, which keeps the diagram alive. Throws ParameterError for invalid options.
  explicit Simulator(const Diagram& diagram, SimulatorOptions options = {});
  explicit Simulator(const std::shared_ptr<const Diagram>& diagram, SimulatorOptions options = {});
  /// Continues with an existing context: a clone, or one that was restored. Throws ParameterError if the
  /// options contain a seed that differs from the context's.
  Simulator(std::unique_ptr<Context> context, SimulatorOptions options = {});
  ~Simulator();

  Context& context() { return *context_; }
  const Context& context() const { return *context_; }

  /// Logs ports and states at a rate. Values at ticks inside an integrator step are read from the dense
  /// output, so no log changes the run.
  void AddLog(Rate rate, std::vector<const Source*> signals, std::vector<std::shared_ptr<LogSink>> sinks);
  /// Logs ports and states to memory.
  std::shared_ptr<MemoryLog> AddLog(Rate rate, std::vector<const Source*> signals);
  /// Delays all rows of the present logs by `seconds` of simulated time on their way to the sinks. If
  /// Context::Restore then sets the run back by at most that time, even sinks that cannot drop rows (see
  /// LogSink) never receive the discarded rows. Throws ParameterError if `seconds` is not positive.
  void HoldLogs(double seconds);
  /// Passes on all held rows, flushes the logs and ends holding.
  void ReleaseLogs();

  /// Runs the AtStart updates and the tick at t = 0. AdvanceTo calls it if necessary.
  RunStatus Initialize();
  /// Runs up to and including the tick at `time` [s], and none after it; a time that misses a tick by
  /// rounding errors, which are small against the distance between ticks, counts as the tick.
  ///
  /// The division of a run into advances does not affect it: the integrator steps past `time` by at most
  /// max_step, up to the next tick or declared jump that changes a derivative, and the states at `time` come
  /// from its dense output, with similar accuracy. So calculations that derivatives or witnesses depend on
  /// are also evaluated at times after `time`. A source of your own whose data end there must hold its last
  /// value, as Table and Trajectory do, or declare their end by a NextJump, where a step ends.
  ///
  /// Throws RunError: an exception of a block (std::rethrow_if_nested gives the original), the first
  /// non-finite value, a failure of the integrator with its worst state, an accumulation of events, or a tick
  /// missed under LatePolicy::kStop. After an error, a tick may be incomplete, and the run cannot continue
  /// until a snapshot is restored.
  [[nodiscard]] RunStatus AdvanceTo(double time);
  /// Runs up to the tick at `time` [s] but not that tick, which happens when the run continues. Values that
  /// the tick reads can be set in between. Does nothing if that tick is already the next at the present time.
  [[nodiscard]] RunStatus AdvanceToBefore(double time);
  /// AdvanceTo for runs that must not end early: throws RunError with the reason if a monitor ends the run.
  void RunTo(double time);
  /// Time of the next tick [s]; infinity if there is none.
  double next_tick_time() const;

  IntegratorStatistics statistics() const;
  /// Real-time statistics of the run; zeros without real_time_rate.
  const RealTimeStatistics& real_time() const { return real_time_; }
  /// How the run time since construction is divided. Throws RunError if `.profile` is not set.
  RunProfile Profile() const;

  /// Calls `monitor` at the start and after every integrator step; if it returns a reason, the run ends. It
  /// must not change the context. In a block, declare a Monitor instead.
  void AddMonitor(std::function<Verdict(Context&)> monitor);

 private:
  void Synchronize();
  bool IsCoarse(double time) const { return !(std::abs(time) <= exact_until_); }
  void RebuildSchedule();
  void MoveSchedule();
  void MakeEventFinder();
  RunStatus Advance(double time, bool before_tick);
  void FirstTick();
  bool EventFeeds() const;
  void HandleEvent();
  void Fire(std::size_t witness);
  void EvaluateWitnesses();
  void MeasureRounding();
  void DecideSides();
  double* EventMemory(std::size_t witness);
  bool KinkFires() const;
  // Functions called at every tick have hidden visibility, so that GCC can inline them.
  [[gnu::visibility("hidden")]] bool MeansNextTick(double time, double rounding) const;
  [[gnu::visibility("hidden")]] bool MeansLastTick(double time, double rounding) const;
  [[gnu::visibility("hidden")]] double RestOf(double time) const;
  [[gnu::visibility("hidden")]] bool IsReached(double target, double rest) const;
  [[gnu::visibility("hidden")]] void IntegrateTo(double target);
  [[gnu::visibility("hidden")]] void StartFinder();
  [[gnu::visibility("hidden")]] void StartIntegrator();
  [[gnu::visibility("hidden")]] double NextJump();
  [[gnu::visibility("hidden")]] void FindEvent(double from);
  [[gnu::visibility("hidden")]] void EndStep();
  [[gnu::visibility("hidden")]] void Tick(bool first = false);
  [[gnu::visibility("hidden")]] const internal::TickPlan& PlanFor(const std::vector<int>& due);
  [[gnu::visibility("hidden")]] void Apply(const internal::UpdatePlan& plan);
  [[gnu::visibility("hidden")]] void HandleJumps();
  [[gnu::visibility("hidden")]] void AskMonitors();
  [[gnu::visibility("hidden")]] void Judge(const std::vector<internal::Op>& ops,
                                           const std::vector<const Source*>& verdicts);
  [[gnu::visibility("hidden")]] void CheckSamples(const internal::TickPlan& plan) const;
  [[gnu::visibility("hidden")]] void KeepPace(bool tick);
  /// Flushes all logs, even if one throws; returns the first exception.
  std::exception_ptr FlushLogs();

  std::unique_ptr<Context> context_;
  SimulatorOptions options_;
  const internal::Program& program_;
  std::unique_ptr<SundialsIntegrator> integrator_;
  std::unique_ptr<internal::Schedule> schedule_;
  std::vector<std::unique_ptr<internal::TickPlan>> plans_;  ///< plans for the combinations that have occurred
  std::vector<int> due_;                                    ///< groups due at a tick, without logs
  std::uint64_t known_edition_ = 0;  ///< edition of the context at the beginning of the last advance
  // Times of the integrator, see SundialsIntegrator.
  double exact_until_ = 0;  ///< a double resolves later times so coarsely that intervals need an origin [s]
  double horizon_ = 0;      ///< time of the next change of the dynamics at the latest
  bool ends_at_jump_ = false;   ///< the horizon is a declared jump
  double next_stop_ = 0;        ///< the first event in the last step, or its end
  bool stop_is_due_ = false;    ///< the actions at next_stop_ are still to come
  bool is_event_ = false;       ///< next_stop_ is an event of witnesses or kinks
  bool watches_steps_ = false;  ///< updates, monitors or witnesses need every integrator step

  struct RatedLog {
    Rate rate;
    std::vector<std::unique_ptr<SignalLog>> logs;
  };
  std::vector<RatedLog> logs_;

  std::vector<std::function<Verdict(Context&)>> monitors_;
  std::unique_ptr<internal::Profiler> profiler_;

  std::unique_ptr<internal::EventFinder> finder_;
  std::vector<double> witness_values_;
  std::vector<std::size_t> fired_;  ///< witnesses and kinks of the event at next_stop_

  std::optional<std::string> end_reason_;
  const Source* ended_by_ = nullptr;        ///< see RunStatus::monitor
  std::optional<std::int64_t> pace_start_;  ///< on the clock [ns]
  double pace_start_time_ = 0;
  std::optional<std::int64_t> tick_began_;  ///< on the clock [ns]
  RealTimeStatistics real_time_;
};

}  // namespace tenon
