#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct RandomWalkParams {
  T density = internal::Filled<T>(1);          ///< standard deviation after 1 s [unit/sqrt(s)], 0 or more
  T start_deviation = internal::Filled<T>(0);  ///< standard deviation at the start [unit], 0 or more
  Rate rate = Hz(1000);
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
};

/// A random walk, a model of sensor bias drift. With h the period:
///
///     y[n + 1] = y[n] + density sqrt(h) e[n],   y[0] = start_deviation e,   e, e[n] ~ N(0, 1)
///
/// T is double or Vec<N>. The variance is start_deviation^2 + density^2 t at any rate; with a density of 0 y
/// is a constant bias. The random numbers are determined by the run's seed and the block's path. Throws
/// ParameterError if a density or deviation is negative or not finite.
template <internal::DoubleOrMatrix T = double>
class RandomWalk final : public LeafSystem<RandomWalkParams<T>> {
 public:
  using LeafSystem<RandomWalkParams<T>>::LeafSystem;
  using LeafSystem<RandomWalkParams<T>>::params;
  Parameter<T> density{this,
                       {"density", internal::Per(params.unit, "sqrt(s)"), params.elements},
                       params.density,
                       "noise density",
                       Range().AtLeast(0)};
  Parameter<T> start_deviation{this,
                               {"start_deviation", params.unit, params.elements},
                               params.start_deviation,
                               "initial deviation",
                               Range().AtLeast(0)};
  Random random{this, "random"};
  DiscreteState<T> x{this, {"x", params.unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(x), [](const T& v) -> const T& {
        return v;
      }};
  Update<T> start{x, AtStart{}, Uses(start_deviation, random), [](const T& sigma, RandomStream& stream) -> T {
                    const auto draw = [&stream](double deviation) { return deviation * stream.Normal(); };
                    return internal::Elementwise(draw, sigma);
                  }};
  Update<T> next{x, Sampled{params.rate}, Uses(x, density, random),
                 [this](const T& x_now, const T& sigma, RandomStream& stream) -> T {
                   const auto step = [&stream, root = std::sqrt(params.rate.period())](double x_i,
                                                                                       double density_i) {
                     return x_i + density_i * root * stream.Normal();
                   };
                   return internal::Elementwise(step, x_now, sigma);
                 }};
};

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
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(x), [](const T& v) -> const T& {
        return v;
      }};
  Update<T> start{x, AtStart{}, Uses(standard_deviation, random),
                  [](const T& sigma, RandomStream& stream) -> T {
                    const auto draw = [&stream](double deviation) { return deviation * stream.Normal(); };
                    return internal::Elementwise(draw, sigma);
                  }};
  Update<T> next{x, Sampled{params.rate}, Uses(x, standard_deviation, time_constant, random),
                 [this](const T& x_now, const T& sigma, double tau, RandomStream& stream) -> T {
                   const double h = params.rate.period();
                   const double a = std::exp(-h / tau), b = std::sqrt(-std::expm1(-2 * h / tau));
                   const auto step = [&](double x_i, double deviation) {
                     return a * x_i + b * deviation * stream.Normal();
                   };
                   return internal::Elementwise(step, x_now, sigma);
                 }};
};

}  // namespace tenon
