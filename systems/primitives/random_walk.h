#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>
#include <tenon/systems/primitives/internal/per.h>

#include <cmath>
#include <string>

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
///     | port            | kind            | size | unit         |
///     | density         | Parameter       | T    | unit/sqrt(s) |
///     | start_deviation | Parameter       | T    | unit         |
///     | y               | output, sampled | T    | unit         |
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
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(x), [](const T& x) -> const T& {
        return x;
      }};
  Update<T> start{x, AtStart{}, Uses(start_deviation, random),
                  [](const T& start_deviation, RandomStream& random) -> T {
                    const auto draw = [&random](double deviation) { return deviation * random.Normal(); };
                    return internal::Elementwise(draw, start_deviation);
                  }};
  Update<T> next{x, Sampled{params.rate}, Uses(x, density, random),
                 [this](const T& x, const T& density, RandomStream& random) -> T {
                   const auto step = [&random, root = std::sqrt(params.rate.period())](double x,
                                                                                       double density) {
                     return x + density * root * random.Normal();
                   };
                   return internal::Elementwise(step, x, density);
                 }};
};

}  // namespace tenon
