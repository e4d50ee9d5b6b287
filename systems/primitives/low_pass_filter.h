#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct LowPassFilterParams {
  double time_constant = 0.1;          ///< [s]; the cut-off frequency is 1 / (2 pi time_constant) Hz
  T initial = internal::Filled<T>(0);  ///< y at t = 0 [unit]
  std::string unit = "";               ///< unit of input and output
  std::string elements = "";           ///< names of the elements
  void Validate() const { Demand(internal::IsFinite(initial), "initial must be finite"); }
};

/// A continuous first-order low-pass filter with gain 1:
///
///     T dy/dt = u - y,   y(0) = initial
///
/// T is double or Vec<N>. The output does not depend on the present input, so the block breaks loops.
/// Throws ParameterError if the time constant is not positive or the initial value is not finite.
template <internal::DoubleOrMatrix T = double>
class LowPassFilter final : public LeafSystem<LowPassFilterParams<T>> {
 public:
  using LeafSystem<LowPassFilterParams<T>>::LeafSystem;
  using LeafSystem<LowPassFilterParams<T>>::params;
  Parameter<double> time_constant{this,
                                  {"time_constant", "s"},
                                  params.time_constant,
                                  "time constant of the filter",
                                  Range().Positive().OrInfinite()};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  ContinuousState<T> x{this, {"y", params.unit, params.elements}, params.initial};
  OutputPort<T> y{this, x};
  TimeDerivative<T> dx{x, Uses(x, u, time_constant), [](const T& x_now, const T& u_now, double tau) -> T {
                         return (1 / tau) * (u_now - x_now);
                       }};
};

template <internal::DoubleOrMatrix T = double>
struct DiscreteLowPassParams {
  double time_constant = 0.1;          ///< [s]
  T initial = internal::Filled<T>(0);  ///< y at the first tick [unit]
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
  void Validate() const { Demand(internal::IsFinite(initial), "initial must be finite"); }
};

/// A sampled first-order low-pass filter, for controllers. For an input that is held between ticks, its
/// output at the ticks equals that of LowPassFilter. With h the period:
///
///     y[n + 1] = y[n] + (1 - exp(-h / T)) (u[n] - y[n]),   y[0] = initial
///
/// T is double or Vec<N>. The output does not depend on the present input, so the block breaks loops.
/// Throws ParameterError if the time constant is not positive or the initial value is not finite.
template <internal::DoubleOrMatrix T = double>
class DiscreteLowPass final : public LeafSystem<DiscreteLowPassParams<T>> {
 public:
  using LeafSystem<DiscreteLowPassParams<T>>::LeafSystem;
  using LeafSystem<DiscreteLowPassParams<T>>::params;
  Parameter<double> time_constant{this,
                                  {"time_constant", "s"},
                                  params.time_constant,
                                  "time constant of the filter",
                                  Range().Positive().OrInfinite()};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  DiscreteState<T> x{this, {"x", params.unit, params.elements}, params.initial};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(x), [](const T& v) -> const T& {
        return v;
      }};

 private:
  Shared<double> blend_{this, "blend", Uses(time_constant),
                        [this](double tau) { return -std::expm1(-params.rate.period() / tau); }};

 public:
  Update<T> next{
      x, Sampled{params.rate}, Uses(x, u, blend_),
      [](const T& x_now, const T& u_now, double blend) -> T { return x_now + blend * (u_now - x_now); }};
};

}  // namespace tenon
