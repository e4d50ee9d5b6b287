#pragma once

#include <string>

#include <tenon/systems/framework/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct NoiseParams {
  T standard_deviation = internal::Filled<T>(1);  ///< [unit], 0 or more
  Rate rate = Hz(1000);
  std::string unit = "";
  void Validate() const {
    Demand(internal::IsFinite(standard_deviation) &&
               internal::Everywhere([](double deviation) { return deviation >= 0; }, standard_deviation),
           "standard_deviation must be finite and not negative, in every element");
  }
};

namespace internal {
template <DoubleOrMatrix T>
T NormalSample(const T& standard_deviation, RandomStream& random) {
  return Elementwise([&](double deviation) { return deviation * random.Normal(); }, standard_deviation);
}
}  // namespace internal

/// Band-limited white noise: independent normal numbers of mean 0, one per element and tick, held between.
///
///     y[n] ~ N(0, standard_deviation^2)
///
///     | port | kind            | size | unit |
///     | y    | output, sampled | T    | unit |
///
/// T is double or Vec<N>. Its one-sided power spectral density well below rate / 2 is
/// 2 standard_deviation^2 / rate. The numbers follow from the run's seed and the block's path.
/// Throws ParameterError if a standard deviation is negative or not finite.
template <internal::DoubleOrMatrix T = double>
class WhiteNoise final : public LeafSystem<NoiseParams<T>> {
 public:
  using LeafSystem<NoiseParams<T>>::LeafSystem;
  using LeafSystem<NoiseParams<T>>::params;
  Random random{this, "random"};
  OutputPort<T> y{
      this, {"y", params.unit}, Sampled{params.rate}, Uses(random), [this](RandomStream& random) -> T {
        return internal::NormalSample(params.standard_deviation, random);
      }};
};

/// A sampled measurement with white noise on it.
///
///     y[n] = u[n] + e[n],   e[n] ~ N(0, standard_deviation^2)
///
///     | port | kind            | size | unit |
///     | u    | input           | T    | unit |
///     | y    | output, sampled | T    | unit |
///
/// Feedthrough at its ticks. Otherwise as WhiteNoise.
template <internal::DoubleOrMatrix T = double>
class AddNoise final : public LeafSystem<NoiseParams<T>> {
 public:
  using LeafSystem<NoiseParams<T>>::LeafSystem;
  using LeafSystem<NoiseParams<T>>::params;
  InputPort<T> u{this, {"u", params.unit}};
  Random random{this, "random"};
  OutputPort<T> y{this,
                  {"y", params.unit},
                  Sampled{params.rate},
                  Uses(u, random),
                  [this](const T& u, RandomStream& random) -> T {
                    return u + internal::NormalSample(params.standard_deviation, random);
                  }};
};

}  // namespace tenon
