#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/simulation/internal/event_finder.h>
#include <tenon/systems/simulation/internal/sundials_solver.h>

namespace tenon {

/// Integrates a context's continuous states with SUNDIALS, through internal::SundialsSolver. It integrates
/// ahead, to `finish`; the context can then be moved to any time in the last step. A Simulator uses it
/// between the instants at which the dynamics change.
///
/// Its times are SUNDIALS's, see Local: near t = 0 those of the run; at large times, which a double resolves
/// only coarsely, they count from the beginning of the interval.
class SundialsIntegrator {
 public:
  /// Up to the next change of the dynamics, at `end` + `end_rest` in the run's time [s]; infinity if there is
  /// none.
  struct Interval {
    double end = 0;
    double end_rest = 0;
    bool jumps = false;  ///< `end` is a declared jump, and the dynamics must not be evaluated there
    bool local = false;  ///< times count from the beginning of the interval, not from that of the run
  };

  /// Throws ParameterError for an order that the method does not have, or non-positive tolerances.
  static std::unique_ptr<SundialsIntegrator> Make(Context& context, const SimulatorOptions& options);
  virtual ~SundialsIntegrator() = default;

  /// Returns whether the integration can continue. If not (initially, after Halt, and after the context was
  /// changed from outside), call Start.
  virtual bool can_go_on() const = 0;
  /// Starts at the context's time and states. If the context is inside a recorded step (after Clone or
  /// Restore), repeats that step and continues bit for bit; implicit and multistep methods, which use past
  /// steps, repeat from their last start. Returns whether a step was repeated.
  virtual bool Start(const Interval& interval) = 0;
  /// Ends the interval, because the dynamics change here: the next advance begins with Start.
  virtual void Halt() = 0;
  /// Integrates to the end of the interval or, with `one_step`, by one step. Throws RunError: an exception of
  /// a block, the first non-finite value, or the cause of a failure. The context is at an undefined time
  /// until MoveContext is called.
  virtual void Advance(bool one_step) = 0;
  /// Goes back to the beginning of the last step, to end the interval just before an event that changes the
  /// derivatives, unless the event is at the beginning of the step. Returns whether it went back.
  virtual bool RetakeBefore(double event) = 0;
  /// True if the interval ends just before an event because of RetakeBefore, also after Start in such an
  /// interval.
  virtual bool ends_before_event() const = 0;
  /// The beginning and the end of the last step [s]; the beginning is known only after one_step.
  double begin() const { return begin_; }
  double finish() const { return finish_; }
  /// The integrator's time at `time` + `rest` of the run.
  virtual double Local(double time, double rest) const = 0;
  /// Tolerance for a time that is computed in two ways. A shorter interval cannot be integrated.
  virtual double rounding(double time) const = 0;
  /// The length of the next step after Start [s], at most.
  virtual double reach() const = 0;
  /// Moves the context to `time` in the last step.
  virtual void MoveContext(double time) = 0;
  /// Moves the context to `time` + `rest` of the run, in the last step.
  virtual void MoveContext(double time, double rest) = 0;
  /// Computes the values of all witnesses and kinks at `time` in the last step.
  virtual void EvaluateWitnesses(double time, double* values) = 0;
  /// The values of all witnesses and kinks near the context's time and states. EndMotion sets these back.
  virtual internal::EventFinder::Motion& BeginMotion() = 0;
  virtual void EndMotion() = 0;
  /// Returns whether the derivatives jump at an event in the last step by so much that the next step is
  /// wrong.
  virtual bool JumpsAt(double event) = 0;
  virtual IntegratorStatistics statistics() const = 0;

 protected:
  double begin_ = 0, finish_ = 0;

 private:
  struct Run;
};

}  // namespace tenon

namespace tenon::internal {

/// Tolerance [s] for a time computed in two ways with one or two additions, which differ by a few units in
/// the last place. A shorter interval cannot be integrated.
inline double Tiny(double time) {
  return 1e-14 * (1 + std::abs(time));
}

}  // namespace tenon::internal
