#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/simulation/internal/sundials_solver.h>
#include <tenon/systems/simulation/simulator_options.h>

#include <memory>
#include <vector>

namespace tenon {

/// Moves a context's continuous states in time with SUNDIALS, through internal::SundialsSolver. It integrates
/// ahead, to `finish`; the context can then be moved to any time in the last step. A Simulator uses it
/// between the instants that change what is integrated.
class SundialsIntegrator {
 public:
  /// Throws ParameterError for an order that the method does not have, or tolerances that are not positive.
  SundialsIntegrator(Context& context, const SimulatorOptions& options);
  ~SundialsIntegrator();

  /// Whether it can go on from where it has come. If not (at first, after Halt, and when the context was
  /// changed by hand) Start is due.
  bool can_go_on() const;
  /// Starts at the context's time and states. If the context says in which step it was (a clone, or one that
  /// was restored), takes that step again and goes on from there, bit for bit; implicit and multistep
  /// methods, which have a past, begin where they started last. `end` is when the integrated dynamics change
  /// next, infinity if never; `jumps` says whether a declared jump is what changes them, so that they must
  /// not be evaluated at `end`. Returns whether a step was taken again.
  bool Start(double end, bool jumps);
  /// The integrated dynamics change here: the next advance begins with Start.
  void Halt();
  /// Integrates to the end of the interval or, with `one_step`, by one step. Throws RunError: what a block
  /// threw, the first value that is not finite, or the cause of the failure. The context is at an undefined
  /// time until MoveContext is called.
  void Advance(bool one_step);
  /// Goes back to the beginning of the last step, to end the interval just before an event in it that changes
  /// the derivatives; not if the event lies at the very beginning. Returns whether it did.
  bool RetakeBefore(double event);
  /// Whether the interval ends just before an event, by RetakeBefore; also after Start in such an interval.
  bool ends_before_event() const;
  /// The beginning and the end of the last step [s]; the beginning is known after one_step alone.
  double begin() const;
  double finish() const;
  /// Moves the context to `time`, in the last step.
  void MoveContext(double time);
  /// Computes the values of all witnesses and kinks at `time`, in the last step.
  void EvaluateWitnesses(double time, double* values);
  IntegratorStatistics statistics() const;

 private:
  struct Run;
  std::unique_ptr<Run> run_;
};

}  // namespace tenon
