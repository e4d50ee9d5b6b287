#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct DiscreteDerivativeParams {
  double time_constant = 0;  ///< time constant of the low-pass filter [s]; 0 for no filter
  Rate rate = Hz(1000);
  std::string u_unit = "";    ///< unit of the input
  std::string y_unit = "";    ///< unit of the output: u_unit per second
  std::string elements = "";  ///< names of the elements of u and y
};

/// The derivative of a sampled signal, with a first-order low-pass filter, by backward differences. With T
/// the time constant and h the period:
///
///     y[n] = (T y[n - 1] + u[n] - u[n - 1]) / (T + h),   y[0] = 0
///
/// T is double or Vec<N>. Feedthrough at its ticks; for a smooth signal the lag is T + h / 2. Throws
/// ParameterError if the time constant is negative or not finite.
template <internal::DoubleOrMatrix T = double>
class DiscreteDerivative final : public LeafSystem<DiscreteDerivativeParams> {
  using Difference = internal::FilteredDifference<T>;

 public:
  using LeafSystem::LeafSystem;
  Parameter<double> time_constant{
      this, {"time_constant", "s"}, params.time_constant, "time constant of the filter", Range().AtLeast(0)};
  InputPort<T> u{this, {"u", params.u_unit, params.elements}};
  DiscreteState<Difference> x{this, "x"};

 private:
  Shared<Difference> next_{this, "next", Uses(x, u, time_constant),
                           [this](const Difference& x_now, const T& u_now, double tau) {
                             return x_now.Next(u_now, tau, params.rate.period());
                           }};

 public:
  OutputPort<T> y{this,
                  {"y", params.y_unit, params.elements},
                  Sampled{params.rate},
                  Uses(next_),
                  [](const Difference& next) -> const T& { return next.d; }};
  Update<Difference> update{x, Sampled{params.rate}, Uses(next_),
                            [](const Difference& next) -> const Difference& { return next; }};
};

}  // namespace tenon
