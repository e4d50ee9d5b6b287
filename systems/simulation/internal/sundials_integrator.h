#pragma once

#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <tenon/systems/framework/context.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon {

/// Moves a context's continuous states in time with SUNDIALS, by way of internal::SundialsSolver. A Simulator
/// uses it between ticks.
class SundialsIntegrator {
 public:
  /// Throws ParameterError for an order that the method does not have, or tolerances that are not positive.
  SundialsIntegrator(Context& context, const SimulatorOptions& options);
  ~SundialsIntegrator();

  enum class Stop { kArrived, kRoot, kStep };

  /// Restarts from the context's time and states, for an interval that ends at `end`. Needed whenever
  /// anything but Advance has changed them or a held value.
  void Restart(double end);
  /// Integrates to the end of the interval, to a root of a witness, or (`one_step`) for one step. Throws
  /// RunError: what a block threw, the first value that is not finite, or the worst state by name.
  Stop Advance(bool one_step);
  /// After kRoot: +1 or -1 for witnesses that rose or fell, else 0.
  const std::vector<int>& roots() const;
  IntegratorStatistics statistics() const;

 private:
  struct Run;
  std::unique_ptr<Run> run_;
};

}  // namespace tenon
