#pragma once

#include <tenon/systems/framework/context/context.h>

namespace tenon {

/// A figure of a run and its derivative with respect to numbers in the run's initial context.
struct SensitivityResult {
  double figure = 0;               ///< figure of the nominal run
  Eigen::VectorXd gradient;        ///< [unit of the figure / unit of the number]
  std::vector<std::string> names;  ///< names of the numbers, such as "pd.kp"
  std::vector<std::string> units;
};

struct SensitivityOptions {
  double step = 1e-4;  ///< central differences vary a number by step * scale
  /// Scales by unit ("N/m"); default: |value|, or 1 if that is 0.
  std::map<std::string, double> scales = {};
};

/// A function that runs from a given context and returns one figure:
///
///     [&](std::unique_ptr<Context> start) {
///       Simulator simulator(std::move(start), {.order = 5, .rtol = 1e-9});
///       const auto log = simulator.AddLog(Hz(100), {&cart.state});
///       simulator.RunTo(5);
///       return SquareMean(log->column("cart.state.position"));
///     }
using Figure = std::function<double(std::unique_ptr<Context>)>;

/// Computes the derivative of a figure with respect to all real numbers of the sources by central differences
/// of runs from clones of a context:
///
///     dJ/dp = (J(p + h) - J(p - h)) / 2 h
///
/// `sources` must be settable by Context::SetDoubles: Parameters, open inputs, states, Scratch, and held
/// samples that the run reads before it computes them again. Random streams are equal in all runs (common
/// random numbers: P. Glasserman, Monte Carlo Methods in Financial Engineering, 2004, sec. 7.1), so that the
/// derivative is that of one realisation. The simulator's tolerances should be well below `step`.
///
/// Throws ParameterError for a step or scale that is not positive. Throws RunError if a source cannot be set
/// or holds no real number and, with the varied number, if a figure is not finite or its function throws an
/// Error.
SensitivityResult Sensitivity(const Context& context, const std::vector<const Source*>& sources,
                              const Figure& figure, const SensitivityOptions& options = {});

}  // namespace tenon
