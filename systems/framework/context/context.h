#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>

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

/// All data of a run that changes: time, states, held samples, scratch, random streams, and the memory of the
/// step-size control. Clone it to branch a run; save it to continue a run later, bit for bit.
class Context {
 public:
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const Diagram& diagram() const { return *diagram_; }
  double time() const { return *reinterpret_cast<const double*>(memory_.get()); }
  std::uint64_t seed() const { return seed_; }

  /// Returns the value of a port, state, shared value or witness, and computes it if necessary. Throws
  /// RunError if that needs a sampled output that has not run yet or an open input without a value.
  template <class S>
  const typename S::Value& Eval(const S& source) {
    return *static_cast<const typename S::Value*>(EvalAddress(source));
  }
  /// Evaluates a source of a const context; a value that is not known yet is computed in a clone.
  template <class S>
  typename S::Value Eval(const S& source) const {
    if (!IsKnown(source)) return Clone()->Eval(source);
    return *static_cast<const typename S::Value*>(static_cast<const void*>(Address(source)));
  }
  /// Returns all elements of a source's value as doubles, for sources that are known only by path.
  std::vector<double> EvalDoubles(const Source& source);

  /// Names and units of the elements of a source, with the present sizes where these are known only at run
  /// time.
  std::vector<Element> Elements(const Source& source) const;

  /// Sets a state, scratch or Parameter, fixes an open input, or overwrites a held sample. Throws RunError if
  /// the source is computed or connected, and ParameterError if a Parameter's value is not a number or its
  /// block rejects it; in both cases the context is unchanged.
  template <class S>
  void Set(const S& source, const typename S::Value& value) {
    Assign({&source, &value});
  }
  /// Sets several Parameters at once, where setting them one by one would be invalid:
  /// `Set(pd.low, 3, pd.high, 5)`.
  template <class S, class... More>
  requires(sizeof...(More) >= 2 && sizeof...(More) % 2 == 0)  //
      void Set(const S& parameter, const typename S::Value& value, const More&... more) {
    std::vector<Assignment> list;
    Collect(list, parameter, value, more...);
  }
  /// Sets the elements of a source that is known only by path. Throws RunError if the number of values is
  /// wrong, and ParameterError if an element cannot hold its value (a fraction for an integer, say).
  void SetDoubles(const Source& source, std::span<const double> values);
  void SetTime(double time);

  /// All continuous states [SI units], in the order of Diagram::ContinuousStateNames().
  Eigen::Map<const Eigen::VectorXd> continuous_state() const;
  void SetContinuousState(const Eigen::Ref<const Eigen::VectorXd>& state);
  /// Time derivatives of the continuous states at the present values. Throws RunError if they need a sampled
  /// output that has not run yet or an open input without a value.
  Eigen::VectorXd EvalTimeDerivatives();
  /// The right-hand side for an integrator: moves to time `t` [s] and states `x`, and writes ẋ to `xdot`.
  /// Samples, modes and the values that depend only on them stay unchanged. Does not allocate.
  void CalcTimeDerivatives(double t, const double* x, double* xdot);

  std::unique_ptr<Context> Clone() const;
  /// Returns the whole context as bytes. A run that was saved inside an integrator step continues bit for bit
  /// by repeating that step; implicit and multistep methods, which use past steps, restart from the last tick
  /// that restarted them. Throws RunError that names a held value whose type cannot be stored.
  std::vector<std::byte> Save() const;
  /// Restores bytes that Save returned for a context of the same diagram. Throws RunError with the reason,
  /// and changes nothing, if they are from another diagram or version, truncated or damaged (they carry a
  /// checksum). When the run continues, its logs drop the rows after the restored time, see LogSink.
  void Restore(std::span<const std::byte> bytes);
  /// Save and Restore with a file, which is replaced atomically. Throw RunError (OutputError) that names the
  /// file if it cannot be written or read.
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
                  "Set: only Parameters can be set several at once.");
    list.push_back({&parameter, &value});
    if constexpr (sizeof...(More) > 0) {
      Collect(list, more...);
    } else {
      AssignParameters(list);
    }
  }
  void Assign(const Assignment& assignment);
  void AssignParameters(std::span<const Assignment> list);
  void CheckDeclaredSize(const Source& source, const void* value) const;

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
  /// Marks all calculations stale; with `settled`, also those that depend only on Parameters.
  void MarkAllStale(bool settled = true);
  /// Forgets what follows from the values before a change from outside.
  void ForgetRun();
  [[gnu::visibility("hidden")]] double* continuous_data();
  [[gnu::visibility("hidden")]] double* derivative_data();
  /// Copies `x` to all continuous states.
  [[gnu::visibility("hidden")]] void LoadStates(const double* x);
  /// Copy values of run-time size from and to their places among the continuous states or derivatives.
  void UnpackStates();
  void PackStates();
  [[gnu::visibility("hidden")]] void PackDerivatives();

  // Functions for a run. Each runs a list of calculations and reports exceptions with their path and the
  // time. The functions that every evaluation calls have hidden visibility, so that GCC can inline them.
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
  /// Copies the values of the witnesses and kinks. Throws RunError if one is not a number.
  void ReadWitnesses(double* values) const;
  std::vector<double> HeldNumbers(const Source& source) const;
  void CheckUpdates(const internal::UpdatePlan& plan) const;
  /// Describes the first non-finite value in dataflow order, as "'pd.u[1]' is nan"; empty if there is none.
  std::string DescribeNonFinite() const;
  /// Describes the first non-finite number of `source`, whose value is stored in `holder`.
  std::string DescribeNonFinite(const Source& source, const Source& holder) const;

  std::shared_ptr<const Diagram> diagram_;
  std::unique_ptr<std::byte, Free> memory_;
  std::uint64_t seed_;
  /// A calculation that varies is fresh if its stamp is `instant_`; any other if its stamp is not 0.
  std::vector<std::uint64_t> stamps_;
  std::uint64_t instant_ = 1;
  std::vector<bool> fixed_;  ///< whether each open input has been set

  internal::Profiler* profiler_ = nullptr;  ///< profiler of the running simulator; null if not profiling
  bool checks_values_ = true;               ///< see SimulatorOptions::check_values

  /// Number of changes made from outside the run.
  std::uint64_t edition_ = 0;

  // Progress of a run, and the memory of the step-size control.
  enum class Progress : std::uint8_t {
    kNew,       ///< not started
    kTickDone,  ///< everything up to the present time is done
    kStarted,   ///< AtStart updates are done, but no tick
    kTickDue,   ///< a tick at the present time is still to come
  };
  Progress progress_ = Progress::kNew;
  std::string failure_;    ///< why the run cannot continue
  double time_rest_ = 0;   ///< the present instant minus time(), which rounds it [s]
  double begin_time_ = 0;  ///< the last time that was set [s]
  double next_step_ = 0;
  double last_error_ = 0;
  /// The side of zero of each witness, see internal::EventFinder; empty if it follows from the values.
  std::vector<double> witness_memory_;
  /// The last events of each witness, see Simulator::Fire; empty if there were none.
  std::vector<double> event_memory_;
  /// Successive integrator steps, and the sum of the movements of those that are watched, see
  /// SimulatorOptions::max_steps.
  double num_steps_ = 0, movement_ = 0;
  /// Initial data that brings the integrator back to the present time if the context is inside a step or at
  /// its end: the states, the step size, and the memories of the step-size control and the witnesses.
  struct StepStart {
    bool valid = false;
    bool failed = false;        ///< attempts at the step failed
    bool after_retake = false;  ///< the interval before ended just before an event
    /// Times count from the origin.
    double origin = 0, time = 0, size = 0, next_step = 0, last_error = 0;
    double interval_begin = 0;  ///< time at which the integrator was started [s]
    std::vector<double> states = {};
    /// Time from which the step was last searched for events [s], and the memory of the witnesses there.
    double searched_from = 0;
    std::vector<double> witnesses = {};
    /// An undeclared jump of the derivatives that the step ends before or crosses: the interval that contains
    /// it [s], and the size of the step that met it, 0 if there is no jump.
    double jump_from = 0, jump_to = 0, jump_step = 0;
    /// End of the integration interval [s] if it lies just before an event, else infinity.
    double end_before_event = std::numeric_limits<double>::infinity();

    static FieldList Fields() {
      return {{"failed", &StepStart::failed},
              {"after_retake", &StepStart::after_retake},
              {"origin", &StepStart::origin},
              {"time", &StepStart::time},
              {"size", &StepStart::size},
              {"next_step", &StepStart::next_step},
              {"last_error", &StepStart::last_error},
              {"interval_begin", &StepStart::interval_begin},
              {"states", &StepStart::states},
              {"searched_from", &StepStart::searched_from},
              {"witnesses", &StepStart::witnesses},
              {"jump_from", &StepStart::jump_from},
              {"jump_to", &StepStart::jump_to},
              {"jump_step", &StepStart::jump_step},
              {"end_before_event", &StepStart::end_before_event},
              Undescribed(&StepStart::valid)};  // saved separately, before the others
    }
  } step_start_;
};

}  // namespace tenon
