#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/simulation/run_profile.h>
#include <tenon/systems/simulation/signal_log.h>
#include <tenon/systems/simulation/simulator_options.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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
  std::string reason;               ///< what the monitor said, with its path in front
  const Source* monitor = nullptr;  ///< which, if it belongs to a block
};

/// Runs a diagram: integrates from tick to tick of what reaches a derivative, and at each tick computes all
/// due sampled outputs in dataflow order, takes the logs, asks the monitors, and lets all due updates take
/// effect at once.
///
///     Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
///     simulator.RunTo(5);
///     simulator.context().Eval(cart.state);
class Simulator {
 public:
  /// Makes a context of its own, which keeps the diagram alive. Throws ParameterError for options that make
  /// no sense.
  explicit Simulator(const Diagram& diagram, SimulatorOptions options = {});
  explicit Simulator(const std::shared_ptr<const Diagram>& diagram, SimulatorOptions options = {});
  /// Goes on with a context that exists: a clone, or one that was restored. Throws ParameterError if the
  /// options give a seed that it does not have.
  Simulator(std::unique_ptr<Context> context, SimulatorOptions options = {});
  ~Simulator();

  Context& context() { return *context_; }
  const Context& context() const { return *context_; }

  /// Logs ports and states at a rate. What it logs is read from inside the integrator's steps: no log changes
  /// the run.
  void AddLog(Rate rate, std::vector<const Source*> signals, std::vector<std::shared_ptr<LogSink>> sinks);
  /// The same into memory.
  std::shared_ptr<MemoryLog> AddLog(Rate rate, std::vector<const Source*> signals);
  /// From now on the rows of all logs that there are reach their sinks `seconds` of the run's time later: a
  /// run that is set back by no more, by Context::Restore, leaves no trace of what then did not happen even
  /// in sinks that cannot drop rows, see LogSink. Throws ParameterError unless the time is positive.
  void HoldLogs(double seconds);
  /// Hands over all rows that are held, flushes, and holds none any more.
  void ReleaseLogs();

  /// Runs what happens at the start (AtStart updates, the tick at t = 0). AdvanceTo does it if need be.
  RunStatus Initialize();
  /// Runs up to and including the tick at `time` [s]; a sum of periods may miss it by rounding errors.
  /// However a run is divided into advances, it is the same run: where `time` lies inside a step of the
  /// integrator, which steps past it by max_step at most, the states are read from there, with about its
  /// accuracy. Throws RunError: what a block threw (std::rethrow_if_nested gives it as it was), the first
  /// value that is not finite, the integrator's failure with its worst state, events without end, or a tick
  /// that is missed under LatePolicy::kStop. After that the run refuses to go on until a snapshot is
  /// restored: half of a tick may have happened.
  [[nodiscard]] RunStatus AdvanceTo(double time);
  /// The same up to and without the tick at `time`, which happens when the run goes on: so what that tick
  /// reads can be set. With the tick where the run stands already, nothing happens.
  [[nodiscard]] RunStatus AdvanceToBefore(double time);
  /// AdvanceTo for runs that no monitor should end: throws RunError with its reason if one does.
  void RunTo(double time);
  /// Time of the next tick [s], infinity if there is none.
  double next_tick_time() const;

  IntegratorStatistics statistics() const;
  /// How the run keeps to the clock; zeros without real_time_rate.
  const RealTimeStatistics& real_time() const { return real_time_; }
  /// Where the time of the run went, since the simulator was made. Throws RunError unless `.profile` is set.
  RunProfile Profile() const;

  /// Asks `monitor` at the start and after every step of the integrator whether the run goes on: what it
  /// returns, if anything, is the reason for which it ends here. It must not change the context. For one that
  /// belongs to a block, declare a Monitor there.
  void AddMonitor(std::function<Verdict(Context&)> monitor);

 private:
  void Synchronize();
  void RebuildSchedule();
  void MoveSchedule();
  void MakeEventFinder();
  RunStatus Advance(double time, bool before_tick);
  void FirstTick();
  bool EventFeeds() const;
  void HandleEvent();
  void Fire(std::size_t witness);
  void EvaluateWitnesses();
  // Those that every tick takes are hidden from other libraries: only so does GCC inline them.
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
  /// All of them, whatever one throws; returns the first of that.
  std::exception_ptr FlushLogs();

  std::unique_ptr<Context> context_;
  SimulatorOptions options_;
  const internal::Program& program_;
  std::unique_ptr<SundialsIntegrator> integrator_;
  std::unique_ptr<internal::Schedule> schedule_;
  std::vector<std::unique_ptr<internal::TickPlan>> plans_;  ///< those that have occurred
  std::vector<int> due_;                                    ///< groups at a tick, logs left out
  std::uint64_t known_edition_ = 0;                         ///< of the context, when an advance last began
  double horizon_ = 0;                                      ///< what is integrated changes here at the latest
  bool ends_at_jump_ = false;                               ///< by a declared jump
  double next_stop_ = 0;                                    ///< the first event in the last step, or its end
  bool stop_is_due_ = false;                                ///< what happens at next_stop_ has yet to happen
  bool is_event_ = false;                                   ///< at next_stop_ witnesses or kinks fire
  bool watches_steps_ = false;  ///< updates, monitors or witnesses ask for every step of the integrator

  struct RatedLog {
    Rate rate;
    std::vector<std::unique_ptr<SignalLog>> logs;
  };
  std::vector<RatedLog> logs_;

  std::vector<std::function<Verdict(Context&)>> monitors_;
  std::unique_ptr<internal::Profiler> profiler_;

  std::unique_ptr<internal::EventFinder> finder_;
  std::vector<double> witness_values_;
  std::vector<double> memory_at_begin_;  ///< of the finder, where the last step began
  std::vector<std::size_t> fired_;       ///< the witnesses and kinks of the event at next_stop_
  struct Events {
    double instant = -std::numeric_limits<double>::infinity();  ///< of the last one [s]
    int count = 0;                                              ///< at this instant
    double interval = 0;                                        ///< between the last two [s]
    double first_interval = 0;                                  ///< where intervals began to shrink
    int shrinking = 0;  ///< intervals in succession, each shorter than the one before
  };
  std::vector<Events> events_;  ///< of each witness and kink

  std::optional<std::string> end_reason_;
  const Source* ended_by_ = nullptr;        ///< see RunStatus::monitor
  std::optional<std::int64_t> pace_start_;  ///< on the clock [ns]
  double pace_start_time_ = 0;
  RealTimeStatistics real_time_;
};

}  // namespace tenon
