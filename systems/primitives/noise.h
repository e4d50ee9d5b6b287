#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoublesInside T = double>
struct NoiseParams {
  T standard_deviation = internal::FilledOrZero<T>(1);  ///< deviation of each number [unit], at least 0
  Rate rate = Hz(1000);
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
  void Validate() const {
    Demand(internal::TypeInfoOf<T>().fixed,
           "standard_deviation has parts whose size is known only at run time: add noise to the parts of "
           "fixed size, each with a separate block");
    bool good = true;
    internal::ForEachDouble([&](double deviation) { good &= deviation >= 0; }, standard_deviation);
    Demand(good && internal::IsFinite(standard_deviation),
           "standard_deviation must be finite and not negative, in every element");
  }
};

/// Band-limited white noise: independent normal numbers of mean 0, one per element and tick, held between
/// ticks.
///
///     y[n] ~ N(0, standard_deviation^2)
///
/// T is double, Vec<N>, or a struct with Fields(), in which all doubles are random and all other members 0.
/// The one-sided power spectral density well below rate / 2 is 2 standard_deviation^2 / rate. The random
/// numbers are determined by the run's seed and the block's path. Throws ParameterError if a standard
/// deviation is negative or not finite, or if T has parts of run-time size.
template <internal::DoublesInside T = double>
class WhiteNoise final : public LeafSystem<NoiseParams<T>> {
 public:
  using LeafSystem<NoiseParams<T>>::LeafSystem;
  using LeafSystem<NoiseParams<T>>::params;
  Parameter<T> standard_deviation{
      this, {"standard_deviation", params.unit, params.elements}, params.standard_deviation, "noise level"};
  Random random{this, "random"};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Sampled{params.rate},
                  Uses(standard_deviation, random),
                  [](const T& sigma, RandomStream& stream, T* y_out) {
                    internal::ForEachDouble(
                        [&](double& y_i, double deviation) { y_i = deviation * stream.Normal(); }, *y_out,
                        sigma);
                  }};
};

/// A sampled measurement with additive white noise:
///
///     y[n] = u[n] + e[n],   e[n] ~ N(0, standard_deviation^2)
///
/// T is as for WhiteNoise; members of a struct that are not doubles pass unchanged. Feedthrough at its ticks.
/// Throws ParameterError if a standard deviation is negative or not finite, or if T has parts of run-time
/// size.
template <internal::DoublesInside T = double>
class AddNoise final : public LeafSystem<NoiseParams<T>> {
 public:
  using LeafSystem<NoiseParams<T>>::LeafSystem;
  using LeafSystem<NoiseParams<T>>::params;
  Parameter<T> standard_deviation{
      this, {"standard_deviation", params.unit, params.elements}, params.standard_deviation, "noise level"};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  Random random{this, "random"};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Sampled{params.rate},
                  Uses(u, standard_deviation, random),
                  [](const T& u_now, const T& sigma, RandomStream& stream, T* y_out) {
                    *y_out = u_now;
                    internal::ForEachDouble(
                        [&](double& y_i, double deviation) { y_i += deviation * stream.Normal(); }, *y_out,
                        sigma);
                  }};
};

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
                  [](const T& low, const T& high, RandomStream& stream) -> T {
                    const auto draw = [&stream](double least, double most) {
                      return stream.Uniform(least, most);
                    };
                    return internal::Elementwise(draw, low, high);
                  }};
};

}  // namespace tenon
