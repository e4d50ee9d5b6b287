#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/simulation/simulator_options.h>

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

namespace tenon {

/// A bool, integer or enumeration that a small change of a state or input turned over: the map jumps there.
struct Flip {
  std::string signal;  ///< "latch.mode"
  std::string moved;   ///< the state or input whose change did it
};

/// The step from one period to the next, linear about a nominal run:
///
///     x[k+1] = x1 + A (x[k] - x0) + B (u[k] - u0),   y[k] = y0 + C (x[k] - x0) + D (u[k] - u0)
///
/// x[k] is taken right before the tick at t_k = `time` + k `period` [s], y[k] at it, as a log would. Rows and
/// columns are named; units are those of the signals.
struct DiscreteLinearModel {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd x0, u0, y0, x1;
  double time = 0, period = 0;
  std::vector<std::string> states, inputs, outputs;
  /// Columns of A, C and then of B, D: how far the estimate from any one step size is from their mean, at
  /// most.
  Eigen::VectorXd spread;
  std::vector<Flip> flips;
};

struct LinearizeDiscreteOptions {
  double period = 0;  ///< [s], a multiple of the common period of all sample times; 0: that one
  /// What makes up x, of what carries on; empty: all of it. What is left out stays as in the nominal run when
  /// a period begins.
  std::vector<const Source*> states = {};
  std::vector<const Source*> left_out = {};  ///< of these: clocks that advance by whole ticks, say
  /// Central differences move a number by step * scale; several steps are averaged. More than the
  /// simulator's tolerances, or else its errors are what is differentiated.
  std::vector<double> steps = {1e-5};
  /// By unit ("rad/s"); otherwise 1 + |value|.
  std::map<std::string, double> scales = {};
  bool refuse_flips = false;  ///< throw if there are any
  SimulatorOptions simulator = {.order = 5, .rtol = 1e-10, .atol = 1e-12};
};

/// Linearises what a diagram with sampled blocks does over one period, by central differences of runs of the
/// simulator from clones of a context. The context is left as it is.
///
/// x is all that carries on from before one tick to before the next: continuous states, then the real numbers
/// in discrete states and Scratch, then held samples that somebody reads before they are computed again. A
/// sample that is due at `time` is computed there from the others and is no state: so a sampled PD on a plant
/// gives the A of the textbooks, Φ - Γ K. (A map from after a tick to after the next has such samples as
/// states, and for each of them one more eigenvalue 0.) Numbers that are not finite are not moved. Bools,
/// integers, enumerations and what is no number begin as in the nominal run; where a small change turns one
/// of them over, the result says so. Random streams are equal in all runs.
///
/// `inputs` are open inputs, held over the period; `outputs` any ports and states.
///
/// The period is the least common multiple of all sample times, and begins at the first multiple of it at or
/// after the context's time whose tick has yet to happen and by which all samples have begun: the run goes on
/// to there first. A diagram that samples nothing begins at the context's time: its A and B are then those of
/// the plant behind a zero-order hold of `options.period`.
///
/// Throws ParameterError for steps, scales and periods that make no sense; RunError for a run that fails or
/// is ended by a monitor, an input that is sampled, computed or has no value, a state that carries nothing
/// on, numbers whose count changes within the period, and, if they are refused, flips.
DiscreteLinearModel LinearizeDiscrete(const Context& context, const std::vector<const Source*>& inputs,
                                      const std::vector<const Source*>& outputs,
                                      const LinearizeDiscreteOptions& options = {});

}  // namespace tenon
