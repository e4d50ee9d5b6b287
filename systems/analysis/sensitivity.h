#pragma once

#include <tenon/systems/framework/context/context.h>

#include <Eigen/Core>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace tenon {

/// A figure of a run and its derivative with respect to numbers in the context that the run starts from.
struct SensitivityResult {
  double figure = 0;               ///< of the nominal run
  Eigen::VectorXd gradient;        ///< [unit of the figure / unit of the number]
  std::vector<std::string> names;  ///< "pd.kp"
  std::vector<std::string> units;
};

struct SensitivityOptions {
  double step = 1e-4;  ///< central differences move a number by step * scale
  /// By unit ("N/m"); otherwise |value|, or 1 if that is 0.
  std::map<std::string, double> scales = {};
};

/// Runs from a context that it is given, and returns one figure of the run:
///
///     [&](std::unique_ptr<Context> start) {
///       Simulator simulator(std::move(start), {.order = 5, .rtol = 1e-9});
///       const auto log = simulator.AddLog(Hz(100), {&cart.state});
///       simulator.RunTo(5);
///       return SquareMean(log->column("cart.state.position"));
///     }
using Figure = std::function<double(std::unique_ptr<Context>)>;

/// The derivative of a figure with respect to all real numbers of some sources, by central differences of
/// runs from clones of a context:
///
///     dJ/dp = (J(p + h) - J(p - h)) / 2 h
///
/// `sources` are what Context::SetDoubles can set: Parameters, open inputs, states, Scratch, held samples
/// that the run has not computed again when it reads them. Random streams are equal in all runs (common
/// random numbers: P. Glasserman, Monte Carlo Methods in Financial Engineering, 2004, sec. 7.1), so the
/// derivative is that of one realisation. Let the simulator's tolerances be well below `step`.
///
/// Throws ParameterError for a step or scale that is not positive; RunError if a source cannot be set or
/// holds no real number, and, with the number that was moved, for a figure that is not finite or throws an
/// Error.
SensitivityResult Sensitivity(const Context& context, const std::vector<const Source*>& sources,
                              const Figure& figure, const SensitivityOptions& options = {});

}  // namespace tenon
