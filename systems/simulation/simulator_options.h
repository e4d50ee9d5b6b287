#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// The integrators of SUNDIALS.
enum class Method {
  kErk,    ///< ERKStep, explicit Runge-Kutta: 2 midpoint, 3 Bogacki-Shampine, 4 Zonneveld, 5 Dormand-Prince
  kDirk,   ///< ARKStep, diagonally implicit Runge-Kutta of order 2 to 5, for stiff systems
  kBdf,    ///< CVODE, backward differentiation up to `order` (5), for stiff systems without fast samples
  kAdams,  ///< CVODE, Adams-Moulton up to `order` (12), for smooth systems
};

/// An absolute tolerance of its own for the states whose path begins with `prefix`. The integrator's norm is
/// a mean over all states, in which one bad component hides: give small quantities small tolerances.
struct StateTolerance {
  std::string prefix;
  double atol;
};

/// How a Simulator integrates and runs. Designated initialisers read well: `{.order = 3, .rtol = 1e-6}`.
struct SimulatorOptions {
  Method method = Method::kErk;
  int order = 3;
  double rtol = 1e-6;
  double atol = 1e-9;
  std::vector<StateTolerance> state_atol = {};
  double fixed_step = 0;      ///< [s]; 0 chooses steps by the tolerances. Not for CVODE.
  double max_step = 0;        ///< [s]; 0 for no limit
  long max_steps = 100000;    ///< in an advance, between two ticks that restart the integrator
  int max_events = 100;       ///< of witnesses at one instant; more is an error
  double real_time_rate = 0;  ///< 1 paces the run to the clock, 0 runs as fast as it can
  bool profile = false;  ///< whether Simulator::Profile is wanted; each calculation takes some 50 ns more
  bool publish = true;   ///< whether what Publishes send goes out
  /// Of the random streams of a context that the simulator makes, else 0; one that exists has its own.
  std::optional<std::uint64_t> seed = {};
};

/// What the integrator did since the simulator was made.
struct IntegratorStatistics {
  long steps = 0;
  long failed_steps = 0;
  long evaluations = 0;  ///< of the time derivatives
  /// Besides: for the states at ticks and ends that lie inside a step.
  long interpolant_evaluations = 0;
  double last_step = 0;  ///< [s]
  double smallest_step = 0;
  double largest_step = 0;
  int last_order = 0;
};

}  // namespace tenon
