#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// The integrators of SUNDIALS.
enum class Method {
  kErk,    ///< ERKStep, explicit Runge-Kutta: 2 midpoint, 3 Ralston, 4 Zonneveld, 5 Dormand-Prince
  kDirk,   ///< ARKStep, diagonally implicit Runge-Kutta of order 2 to 5, for stiff systems
  kBdf,    ///< CVODE, backward differentiation up to `order` (5), for stiff systems without fast samples
  kAdams,  ///< CVODE, Adams-Moulton up to `order` (12), for smooth systems
  /// ERKStep, explicit Runge-Kutta of order 2 or 3 with one stage more than that takes, for stiff damping
  /// that ticks are too fast for the implicit ones: feet on the ground. Stable with steps of up to 5 over the
  /// fastest rate of decay, more than twice those of kErk.
  kStabilized,
};

/// An absolute tolerance of its own for the states whose path begins with `prefix`. The integrator's norm is
/// a mean over all states, in which one bad component hides: give small quantities small tolerances.
struct StateTolerance {
  std::string prefix;
  double atol;
};

/// What a run that is paced to the clock does when it comes to a tick too late. It is counted in any case,
/// see Simulator::real_time.
enum class LatePolicy {
  kCatchUp,  ///< goes on as fast as it can until it is on time again
  kShift,    ///< takes the present for the time of the tick: what is lost stays lost
  kStop,     ///< throws RunError before the tick
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
  LatePolicy late_policy = LatePolicy::kCatchUp;
  double late_tolerance = 1e-3;  ///< [s] on the clock; a tick that begins later by more is missed
  bool profile = false;  ///< whether Simulator::Profile is wanted; each calculation takes some 50 ns more
  bool publish = true;   ///< whether what Publishes send goes out
  /// Of the random streams of a context that the simulator makes, else 0; one that exists has its own.
  std::optional<std::uint64_t> seed = {};
};

/// How a run has kept to the clock, since the simulator was made. A tick is due when the clock, times
/// real_time_rate, says its time, counted from where the run began or a snapshot was restored; it waits for
/// that, and begins late if the run comes to it later. Time that passes between two advances counts. Logs
/// have ticks too.
struct RealTimeStatistics {
  long ticks = 0;              ///< that had a time on the clock: all but the one where the run began
  long missed = 0;             ///< began later than late_tolerance allows
  double worst_lateness = 0;   ///< [s] on the clock, of all ticks
  double worst_time = 0;       ///< [s] in the run, of that tick
  double missed_lateness = 0;  ///< [s] on the clock, of the tick that was missed last
  double missed_time = 0;      ///< [s] in the run, of that tick
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
