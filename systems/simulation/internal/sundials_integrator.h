#pragma once

#include <memory>
#include <vector>

#include <tenon/systems/framework/context.h>
#include <tenon/systems/simulation/internal/sundials_solver.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon {

using internal::Tiny;

/// Moves a context's continuous states in time with SUNDIALS, by way of internal::SundialsSolver. It
/// integrates ahead: up to `finish`, to which and to any time on the way the context can be moved then. A
/// Simulator uses it between the ticks that change what is integrated.
class SundialsIntegrator {
 public:
  /// Throws ParameterError for an order that the method does not have, or tolerances that are not positive.
  SundialsIntegrator(Context& context, const SimulatorOptions& options);
  ~SundialsIntegrator();

  enum class Stop { kArrived, kRoot, kStep };

  /// Whether it can go on from where it has come. If not (at first, after Halt, and when the context was
  /// changed by hand) Start is due.
  bool can_go_on() const;
  /// Starts at the context's time and states; or, if the context says in which step it was (a clone, or one
  /// that was restored), takes that step again and goes on from there, bit for bit; methods with a past of
  /// their own (implicit ones, multistep ones) begin where they started last. `end` is when what is
  /// integrated will change; infinity if it never does. Returns how the last step that was taken again ended;
  /// kStep if there was none.
  Stop Start(double end);
  /// What is integrated changes here.
  void Halt();
  /// Integrates on: to the end of the interval, to a root of a witness, or (`one_step`) for one step. Throws
  /// RunError: what a block threw, the first value that is not finite, or the worst state by name. The
  /// context is at no certain time until it is moved.
  Stop Advance(bool one_step);
  /// Whether it stands at a root inside a step, which goes on behind it.
  bool in_step() const;
  /// How far it has come [s].
  double finish() const;
  /// Moves the context to `time`, between where Advance began and the finish.
  void MoveContext(double time);
  /// Throws RunError: it takes more steps than SimulatorOptions::max_steps.
  [[noreturn]] void ThrowTooManySteps();
  /// After kRoot: +1 or -1 for witnesses that rose or fell, else 0.
  const std::vector<int>& roots() const;
  IntegratorStatistics statistics() const;

 private:
  struct Run;
  std::unique_ptr<Run> run_;
};

}  // namespace tenon
