#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace tenon {

class Diagram;

namespace internal {
struct Op;
struct Batch;
struct BatchedOps;
struct CalculationInfo;
struct UpdatePlan;
struct TickPlan;
struct Program;
class Profiler;
}  // namespace internal

/// Everything of a run that changes: time, states, held samples, scratch, random streams, and the memory of
/// the step size control. Clone it to branch a run, save it to continue a run later, bit for bit.
class Context {
 public:
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const Diagram& diagram() const { return *diagram_; }
  double time() const { return *reinterpret_cast<const double*>(memory_.get()); }
  std::uint64_t seed() const { return seed_; }

  /// The value of a port, state, shared value or witness, computed if need be. Throws RunError if that needs
  /// a sampled output that has not run yet or an open input that was never fixed.
  template <class S>
  const typename S::Value& Eval(const S& source) {
    return *static_cast<const typename S::Value*>(EvalAddress(source));
  }
  /// The same of a context that must not change: what is not known yet is computed in a clone.
  template <class S>
  typename S::Value Eval(const S& source) const {
    if (!IsKnown(source)) return Clone()->Eval(source);
    return *static_cast<const typename S::Value*>(static_cast<const void*>(Address(source)));
  }
  /// The same for a source known by path only: all its elements as doubles.
  std::vector<double> EvalDoubles(const Source& source);

  /// Names and units of those; sizes known at run time only are the present ones.
  std::vector<Element> Elements(const Source& source) const;

  /// Sets a state, scratch or Parameter, fixes an open input, or overwrites a held sample. Throws RunError
  /// for what is computed or connected, ParameterError for a Parameter's value that is not a number or that
  /// its block does not accept; then nothing is changed.
  template <class S>
  void Set(const S& source, const typename S::Value& value) {
    Assign({&source, &value});
  }
  /// Several Parameters at once, where one alone would not do: `Set(pd.low, 3, pd.high, 5)`.
  template <class S, class... More>
  requires(sizeof...(More) >= 2 && sizeof...(More) % 2 == 0)  //
      void Set(const S& parameter, const typename S::Value& value, const More&... more) {
    std::vector<Assignment> list;
    Collect(list, parameter, value, more...);
  }
  /// The same for a source known by path only; throws RunError if the number of values is wrong, and
  /// ParameterError if an element cannot hold one: a fraction for an integer, say.
  void SetDoubles(const Source& source, std::span<const double> values);
  void SetTime(double time);

  /// All continuous states [SI units], in the order of Diagram::ContinuousStateNames().
  Eigen::Map<const Eigen::VectorXd> continuous_state() const;
  void SetContinuousState(const Eigen::Ref<const Eigen::VectorXd>& state);
  /// Their time derivatives at the present values. Throws RunError if they need a sampled output that has not
  /// run yet or an open input that was never fixed.
  Eigen::VectorXd EvalTimeDerivatives();
  /// What an integrator calls at every stage: moves to time `t` [s] and states `x`, and writes ẋ. Samples,
  /// modes and what depends on them alone stay as they are. Allocates nothing.
  void CalcTimeDerivatives(double t, const double* x, double* xdot);

  std::unique_ptr<Context> Clone() const;
  /// The whole context as bytes. A run that is inside a step of the integrator goes on from it bit for bit,
  /// by taking that step again; implicit and multistep methods, which have a past, begin again at the
  /// last tick that restarted them. Throws RunError that names a held value whose type cannot be stored.
  std::vector<std::byte> Save() const;
  /// Takes over what Save gave, from a context of the same diagram; throws RunError that says why, and
  /// changes nothing, if it is of another diagram or version, cut short or changed: it carries a checksum.
  /// When the run goes on, its logs drop the rows after the restored time, see LogSink.
  void Restore(std::span<const std::byte> bytes);
  /// The same with a file, written as a whole; throws RunError (OutputError) that names the file if it cannot
  /// be written or read.
  void SaveFile(const std::string& file) const;
  void RestoreFile(const std::string& file);

 private:
  friend class Diagram;
  friend class Simulator;
  friend class SundialsIntegrator;
  friend class SignalLog;
  friend class internal::Compiler;

  struct Free {
    void operator()(std::byte* memory) const { ::operator delete(memory, std::align_val_t(64)); }
  };

  struct Assignment {
    const Source* source;
    const void* value;
  };

  Context(std::shared_ptr<const Diagram> diagram, std::uint64_t seed);
  Context(const Context& other, const internal::Program& program);

  template <class S, class... More>
  void Collect(std::vector<Assignment>& list, const S& parameter, const typename S::Value& value,
               const More&... more) {
    static_assert(std::is_base_of_v<internal::ParameterSource, S>,
                  "Set: only Parameters are set several at once.");
    list.push_back({&parameter, &value});
    if constexpr (sizeof...(More) > 0) {
      Collect(list, more...);
    } else {
      AssignParameters(list);
    }
  }
  void Assign(const Assignment& assignment);
  void AssignParameters(std::span<const Assignment> list);

  const void* EvalAddress(const Source& source);
  bool IsKnown(const Source& source) const;
  void* MutableAddress(const Source& source);
  const std::byte* Address(const Source& source) const;
  void Mute(const Source& publish, bool muted);
  void CheckOwned(const Source& source) const;
  void CheckReadable(const Source& source) const;
  void CheckSettable(const Source& source) const;
  void CheckFixed(const Source& origin) const;
  void CheckAllFixed() const;
  void CheckSample(const internal::CalculationInfo& sampled) const;
  void CheckSamplesFor(const std::vector<internal::Op>& ops) const;
  void EnsureFresh(int calculation);
  void Load(std::span<const std::byte> bytes);
  bool IsFresh(const internal::Op& op) const;
  /// `settled`: also what depends on nothing but Parameters.
  void MarkAllStale(bool settled = true);
  [[gnu::visibility("hidden")]] double* continuous_data();
  [[gnu::visibility("hidden")]] double* derivative_data();
  /// Takes over all continuous states.
  [[gnu::visibility("hidden")]] void LoadStates(const double* x);
  /// What values of run-time size hold, and their place among the continuous states, or derivatives.
  void UnpackStates();
  void PackStates();
  [[gnu::visibility("hidden")]] void PackDerivatives();

  // Used by a run. Each runs a list; what throws is reported with its path and the time. What every
  // evaluation takes is hidden from other libraries: only so does GCC inline it.
  void Run(const internal::Op& op);
  void Run(const internal::BatchedOps& list, const internal::Batch& batch);
  [[gnu::visibility("hidden")]] void RunAll(const internal::BatchedOps& list);
  [[gnu::visibility("hidden")]] void RunStale(const internal::BatchedOps& list);
  [[gnu::visibility("hidden")]] void RunStale(std::span<const internal::Op> ops);
  void RunProfiled(std::span<const internal::Op> ops, bool all);
  [[gnu::visibility("hidden")]] void Apply(const internal::UpdatePlan& plan);
  [[gnu::visibility("hidden")]] void SetRunTime(double time);
  [[gnu::visibility("hidden")]] void CalcRunDerivatives(double t, const double* x, double* xdot);
  [[gnu::visibility("hidden")]] void Invalidate(const std::vector<std::uint32_t>& calculations);
  [[noreturn]] void RethrowFrom(const internal::Op& op) const;
  /// Copies the values of the witnesses and kinks; throws RunError for one that is not a number.
  void ReadWitnesses(double* values) const;
  std::vector<double> HeldNumbers(const Source& source) const;
  void CheckUpdates(const internal::UpdatePlan& plan) const;
  /// The first value in dataflow order that is not finite, as "'pd.u[1]' is nan", or nothing.
  std::string DescribeNonFinite() const;
  /// The first number of `source` that is not finite; `holder` holds the value.
  std::string DescribeNonFinite(const Source& source, const Source& holder) const;

  std::shared_ptr<const Diagram> diagram_;
  std::unique_ptr<std::byte, Free> memory_;
  std::uint64_t seed_;
  /// A varying calculation is fresh if its stamp is `instant_`; any other if its stamp is not 0.
  std::vector<std::uint64_t> stamps_;
  std::uint64_t instant_ = 1;
  std::vector<bool> fixed_;  ///< which open inputs have been set

  internal::Profiler* profiler_ = nullptr;  ///< of the simulator that runs it
  bool checks_values_ = true;               ///< see SimulatorOptions::check_values

  /// Counts what anybody but the run has changed.
  std::uint64_t edition_ = 0;

  // Progress of a run, and what the step size control remembers.
  enum class Progress : std::uint8_t {
    kNew,       ///< nothing has happened
    kTickDone,  ///< all that happens up to the present time
    kStarted,   ///< AtStart updates, and no tick yet
    kTickDue,   ///< a tick at the present time has yet to happen
  };
  Progress progress_ = Progress::kNew;
  std::string failure_;  ///< why the run cannot go on
  double next_step_ = 0;
  double last_error_ = 0;
  /// The sides on which witnesses are, see internal::EventFinder; empty where they follow from their values.
  std::vector<double> witness_memory_;
  /// Where the integrator has to begin to come here again, if the context is inside a step or at its end:
  /// with these states, a step of this size and these memories of the step size control and of witnesses.
  struct StepStart {
    bool valid = false;
    double time = 0, size = 0, next_step = 0, last_error = 0;
    std::vector<double> states = {}, witnesses = {};
    /// The end of the integrator's interval [s] if it lies just before an event, else infinity.
    double end_before_event = std::numeric_limits<double>::infinity();

    static FieldList Fields() {
      return {{"time", &StepStart::time},
              {"size", &StepStart::size},
              {"next_step", &StepStart::next_step},
              {"last_error", &StepStart::last_error},
              {"states", &StepStart::states},
              {"witnesses", &StepStart::witnesses},
              {"end_before_event", &StepStart::end_before_event},
              Undescribed(&StepStart::valid)};  // saved apart, before the others
    }
  } step_start_;
};

}  // namespace tenon
