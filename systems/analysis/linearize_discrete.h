#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon {

/// A bool, integer or enumeration that changed when a state or input was varied, which indicates a jump of
/// the map.
struct Flip {
  std::string signal;  ///< "latch.mode"
  std::string moved;   ///< the state or input that was varied
};

/// The linear map from one period to the next about a nominal run:
///
///     x[k+1] = x1 + A (x[k] - x0) + B (u[k] - u0),   y[k] = y0 + C (x[k] - x0) + D (u[k] - u0)
///
/// x[k] is the state just before the tick at t_k = `time` + k `period` [s], and y[k] the output at the tick,
/// as in a log. Rows and columns are named; units are those of the signals.
struct DiscreteLinearModel {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd x0, u0, y0, x1;
  double time = 0, period = 0;
  std::vector<std::string> states, inputs, outputs;
  /// Largest deviation of the estimates for single step sizes from their mean, for the columns of A, C and
  /// then B, D.
  Eigen::VectorXd spread;
  std::vector<Flip> flips;
};

struct LinearizeDiscreteOptions {
  double period = 0;  ///< multiple of the common period of all sample times [s]; 0: the common period
  /// States that form x; empty: all. Other states begin each period as in the nominal run.
  std::vector<const Source*> states = {};
  std::vector<const Source*> left_out = {};  ///< states to exclude, such as clocks that count ticks
  /// Central differences vary a number by step * scale; the results of several steps are averaged. Steps must
  /// exceed the simulator's tolerances, because otherwise its errors are differentiated.
  std::vector<double> steps = {1e-5};
  /// Scales by unit ("rad/s"); default: 1 + |value|.
  std::map<std::string, double> scales = {};
  bool refuse_flips = false;  ///< throw RunError for a flip
  SimulatorOptions simulator = {.order = 5, .rtol = 1e-10, .atol = 1e-12};
};

/// Linearises a diagram with sampled blocks over one period by central differences of simulator runs from
/// clones of a context. The context is left unchanged.
///
/// x is the state just before a tick: continuous states, then the real numbers in discrete states and
/// Scratch, then held samples that are read before they are computed again. A sample that is due at `time` is
/// computed there and is not a state, so that a sampled PD with a plant has the textbook matrix A = Φ - Γ K.
/// (A map from after a tick to after the next one would have such samples as states, each with an additional
/// eigenvalue 0.) Numbers that are not finite are not varied. Bools, integers, enumerations and values that
/// are not numbers begin as in the nominal run; the result lists those that change when a number is varied.
/// Random streams are equal in all runs.
///
/// `inputs` are open inputs, constant over the period; `outputs` are any ports and states.
///
/// The period is the least common multiple of all sample times. It begins at the first multiple, at or after
/// the context's time, whose tick has not happened yet and by which all samples have begun; the run first
/// advances to that time. Without samples, it begins at the context's time, and A and B are those of the
/// plant behind a zero-order hold of `options.period`.
///
/// Throws ParameterError for invalid steps, scales and periods. Throws RunError for a run that fails or is
/// ended by a monitor, for an input that is sampled, computed or has no value, for a state that is not one,
/// for signals of variable size, and for flips if they are refused.
DiscreteLinearModel LinearizeDiscrete(const Context& context, const std::vector<const Source*>& inputs,
                                      const std::vector<const Source*>& outputs,
                                      const LinearizeDiscreteOptions& options = {});

}  // namespace tenon
