#pragma once

#include <tenon/systems/simulation/time_quantiles.h>

#include <cstdint>
#include <string>
#include <vector>

namespace tenon {

/// The integrators of SUNDIALS.
enum class Method {
  /// ERKStep, explicit Runge-Kutta: 2 midpoint, 3 Bogacki-Shampine, 4 Zonneveld, 5 Dormand-Prince. The error
  /// estimate has stages at both ends of a step and inside, so that it detects a jump of the derivative
  /// wherever it lies. A kink that is not declared causes an error of up to 20 tolerances.
  kErk,
  /// ARKStep, diagonally implicit Runge-Kutta of order 2 to 5, for stiff systems. At order 5, a kink that is
  /// not declared causes an error of up to 300 tolerances.
  kDirk,
  kBdf,    ///< CVODE, backward differentiation up to `order` (5), for stiff systems without fast samples
  kAdams,  ///< CVODE, Adams-Moulton up to `order` (12), for smooth systems
  /// ERKStep, explicit Runge-Kutta of order 2 or 3 with one additional stage for stability, for stiff damping
  /// (feet on the ground) between ticks that are too frequent for an implicit method. It is stable for steps
  /// of up to 5 over the fastest rate of decay, more than twice those of kErk. If ticks restart the
  /// integrator, it uses open tables, see kErkOpen.
  kStabilized,
  /// ERKStep of order 2 (midpoint) or 3 (Ralston) with open tables, which have no stage at the end of a step:
  /// one evaluation less per tick if ticks restart the integrator every few milliseconds. Open tables do not
  /// sample the last half (order 2), quarter (order 3) or, for kStabilized, third of a step. A jump of the
  /// derivative in that part, if no NextJump or Kink declares it, causes an undetected error of the remaining
  /// time in the step times the jump. In a diagram without such ticks the method is kErk. Orders 4 and 5 use
  /// the tables of kErk without the additional search for jumps.
  kErkOpen,
};

/// Absolute tolerance for the states whose path begins with `prefix`. The integrator's norm is a mean over
/// all states, which can hide one inaccurate component: give small quantities small tolerances.
struct StateTolerance {
  std::string prefix;
  double atol;
};

/// Action of a real-time run that reaches a tick too late. Late ticks are counted in any case, see
/// Simulator::real_time.
enum class LatePolicy {
  kCatchUp,  ///< runs as fast as possible until it is on time again
  kShift,    ///< shifts the schedule by the delay
  kStop,     ///< throws RunError before the tick
};

/// Options of the integrator and the run. Use designated initialisers: `{.order = 3, .rtol = 1e-6}`.
struct SimulatorOptions {
  Method method = Method::kErk;
  int order = 3;
  double rtol = 1e-6;
  double atol = 1e-9;
  std::vector<StateTolerance> state_atol = {};
  /// [s]; 0 for step-size control by the tolerances. Not for CVODE. Steps also end at ticks, kinks and
  /// events.
  double fixed_step = 0;
  /// Upper limit of the step size [s]; 0 for none. Pulses shorter than a quarter of a step, and pairs of zero
  /// crossings that close together, can lie between the samples of a step and be missed. The default suits
  /// machines that move in seconds; the first step of a run is a hundredth of it.
  double max_step = 0.1;
  /// After this many successive steps, the motion is checked: if steps much shorter than max_step, with no
  /// tick or event of a witness between them, move no state by more than its tolerance on average, the run
  /// makes no progress, which is an error. The number of steps of a run is not limited.
  long max_steps = 100000;
  int max_events = 100;       ///< maximum events of one witness or kink at one instant, within rounding
  double real_time_rate = 0;  ///< 1 runs in real time, 0 as fast as possible
  LatePolicy late_policy = LatePolicy::kCatchUp;
  double late_tolerance = 1e-3;  ///< [s] of wall-clock time; a tick that begins later by more is missed
  bool profile = false;          ///< enables Simulator::Profile; adds some 50 ns to each calculation
  /// Checks new values of states and sampled outputs for NaN, and of continuous states also for infinity.
  /// Witnesses and derivatives are always checked.
  bool check_values = true;
  bool publish = true;  ///< false disables all Publishes
  /// Seed of the random streams of a context that the simulator creates; 0 if empty.
  std::optional<std::uint64_t> seed = {};
};

/// Timing of a real-time run since the simulator was constructed. A tick is due when the wall-clock time
/// since the beginning of the run, or since a snapshot was restored, times real_time_rate equals the tick's
/// time. The run waits until then, and the tick begins late if the run arrives later. Time between two
/// advances counts. Logs also have ticks.
struct RealTimeStatistics {
  long ticks = 0;              ///< all ticks but the one at which the run began
  long missed = 0;             ///< ticks that began later than late_tolerance permits
  double worst_lateness = 0;   ///< [s] of wall-clock time
  double worst_time = 0;       ///< [s] of simulated time, of the tick with the worst lateness
  double missed_lateness = 0;  ///< [s] of wall-clock time, of the last missed tick
  double missed_time = 0;      ///< [s] of simulated time, of the last missed tick
  TimeQuantiles lateness;      ///< wall-clock time from the instant at which a tick is due to its begin
  TimeQuantiles compute;       ///< wall-clock time from the begin of a tick until the run waits for the next
};

/// Counters of the integrator since the simulator was constructed.
struct IntegratorStatistics {
  long steps = 0;
  long failed_steps = 0;
  long evaluations = 0;  ///< evaluations of the time derivatives
  /// Additional evaluations for the states at ticks and ends inside a step.
  long interpolant_evaluations = 0;
  double last_step = 0;  ///< [s]
  double smallest_step = 0;
  double largest_step = 0;
  int last_order = 0;
};

}  // namespace tenon
