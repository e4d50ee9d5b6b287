#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

#include <cmath>
#include <string>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct GaussMarkovParams {
  T standard_deviation = internal::Filled<T>(1);  ///< standard deviation of y [unit], 0 or more
  double time_constant = 1;                       ///< time in which the correlation falls to 1/e [s]
  Rate rate = Hz(1000);
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
};

/// Coloured noise: the first-order Gauss-Markov process, exact at its ticks and held between them. With h the
/// period and T the time constant (Gelb, "Applied Optimal Estimation", MIT Press 1974, chapter 2):
///
///     y[n + 1] = a y[n] + sqrt(1 - a^2) e[n],   a = exp(-h / T),   y[0], e[n] ~ N(0, standard_deviation^2)
///
///     | port               | kind            | size   | unit |
///     | standard_deviation | Parameter       | T      | unit |
///     | time_constant      | Parameter       | double | s    |
///     | y                  | output, sampled | T      | unit |
///
/// T is double or Vec<N>. The process is stationary from the first tick on:
/// E(y(t) y(t + s)) = standard_deviation^2 exp(-|s| / T). The random numbers are determined by the run's seed
/// and the block's path. Throws ParameterError if a standard deviation is negative or the time constant is
/// not positive.
template <internal::DoubleOrMatrix T = double>
class GaussMarkov final : public LeafSystem<GaussMarkovParams<T>> {
 public:
  using LeafSystem<GaussMarkovParams<T>>::LeafSystem;
  using LeafSystem<GaussMarkovParams<T>>::params;
  Parameter<T> standard_deviation{this,
                                  {"standard_deviation", params.unit, params.elements},
                                  params.standard_deviation,
                                  "noise level",
                                  Range().AtLeast(0)};
  Parameter<double> time_constant{
      this, {"time_constant", "s"}, params.time_constant, "correlation time", Range().Positive()};
  Random random{this, "random"};
  DiscreteState<T> x{this, {"x", params.unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(x), [](const T& x) -> const T& {
        return x;
      }};
  Update<T> start{x, AtStart{}, Uses(standard_deviation, random),
                  [](const T& standard_deviation, RandomStream& random) -> T {
                    const auto draw = [&random](double deviation) { return deviation * random.Normal(); };
                    return internal::Elementwise(draw, standard_deviation);
                  }};
  Update<T> next{
      x, Sampled{params.rate}, Uses(x, standard_deviation, time_constant, random),
      [this](const T& x, const T& standard_deviation, double time_constant, RandomStream& random) -> T {
        const double h = params.rate.period();
        const double a = std::exp(-h / time_constant), b = std::sqrt(-std::expm1(-2 * h / time_constant));
        const auto step = [&](double x, double deviation) { return a * x + b * deviation * random.Normal(); };
        return internal::Elementwise(step, x, standard_deviation);
      }};
};

}  // namespace tenon
