#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

#include <string>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct UniformNoiseParams {
  T lower = internal::Filled<T>(-1);  ///< [unit]
  T upper = internal::Filled<T>(1);   ///< [unit]
  Rate rate = Hz(1000);
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
  void Validate() const {
    Demand(internal::Everywhere([](double low, double high) { return low <= high; }, lower, upper),
           "lower must not exceed upper, in any element");
  }
};

/// White noise between two limits: independent uniform numbers, one per element and tick, held between ticks.
///
///     y[n] ~ U[lower, upper)
///
///     | port         | kind            | size   | unit |
///     | lower, upper | Parameter       | T each | unit |
///     | y            | output, sampled | T      | unit |
///
/// T is double or Vec<N>. The mean is (lower + upper) / 2 and the variance (upper - lower)^2 / 12. The random
/// numbers are determined by the run's seed and the block's path. Throws ParameterError if a limit is not
/// finite or a lower limit exceeds its upper limit.
template <internal::DoubleOrMatrix T = double>
class UniformNoise final : public LeafSystem<UniformNoiseParams<T>> {
 public:
  using LeafSystem<UniformNoiseParams<T>>::LeafSystem;
  using LeafSystem<UniformNoiseParams<T>>::params;
  Parameter<T> lower{
      this, {"lower", params.unit, params.elements}, params.lower, "least value", Range().Finite()};
  Parameter<T> upper{
      this, {"upper", params.unit, params.elements}, params.upper, "largest value", Range().Finite()};
  Random random{this, "random"};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Sampled{params.rate},
                  Uses(lower, upper, random),
                  [](const T& lower, const T& upper, RandomStream& random) -> T {
                    const auto draw = [&random](double low, double high) {
                      return random.Uniform(low, high);
                    };
                    return internal::Elementwise(draw, lower, upper);
                  }};
};

}  // namespace tenon
