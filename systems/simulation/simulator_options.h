#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// The integrators of SUNDIALS.
enum class Method {
  /// ERKStep, explicit Runge-Kutta: 2 midpoint, 3 Bogacki-Shampine, 4 Zonneveld, 5 Dormand-Prince. Stages at
  /// both ends of a step and inside make the error estimate see a jump of the derivative wherever it lies.
  /// A bend that nobody declares as a Kink errs by up to 20 tolerances, at order 5 by up to 200.
  kErk,
  kDirk,   ///< ARKStep, diagonally implicit Runge-Kutta of order 2 to 5, for stiff systems
  kBdf,    ///< CVODE, backward differentiation up to `order` (5), for stiff systems without fast samples
  kAdams,  ///< CVODE, Adams-Moulton up to `order` (12), for smooth systems
  /// ERKStep, explicit Runge-Kutta of order 2 or 3 with one stage more than that takes, for damping that is
  /// stiff between ticks that come too fast for an implicit method: feet on the ground. Stable with steps of
  /// up to 5 over the fastest rate of decay, more than twice those of kErk. In a diagram whose ticks restart
  /// the integrator its tables are open, see kErkOpen.
  kStabilized,
  /// ERKStep of order 2 (midpoint) or 3 (Ralston), without a stage at the end of a step: an evaluation less
  /// per tick, where ticks restart the integrator every few milliseconds. These tables see nothing of the
  /// last
  /// half (order 2) or quarter (order 3) of a step; kStabilized, of its last third. A jump of the derivative
  /// there, between two ticks, that no NextJump or Kink declares, errs by that part of the step times the
  /// jump
  /// without a word. In a diagram without such ticks the method is kErk. Orders 4 and 5 have the
  /// tables of kErk, whose steps are then not looked at for jumps that their tables see badly.
  kErkOpen,
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
  double fixed_step = 0;  ///< [s]; 0 chooses steps by the tolerances. Not for CVODE.
  /// [s]; 0 for no limit. A pulse shorter than a quarter of a step, and two crossings of a witness that
  /// close, can lie between the places at which a step looks.
  double max_step = 0.1;
  /// Steps of the integrator within a tenth of a second; more is an error, as the run makes no progress. The
  /// length of a run, and how it is divided into advances, do not matter.
  long max_steps = 100000;
  int max_events = 100;       ///< of one witness or kink at one instant; more is an error
  double real_time_rate = 0;  ///< 1 paces the run to the clock, 0 runs as fast as it can
  LatePolicy late_policy = LatePolicy::kCatchUp;
  double late_tolerance = 1e-3;  ///< [s] on the clock; a tick that begins later by more is missed
  bool profile = false;  ///< whether Simulator::Profile is wanted; each calculation takes some 50 ns more
  /// Whether what updates give states, and sampled outputs, is checked for NaN (states that are integrated
  /// for infinity too) where it arises. Witnesses and derivatives always are.
  bool check_values = true;
  bool publish = true;  ///< whether what Publishes send goes out
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
