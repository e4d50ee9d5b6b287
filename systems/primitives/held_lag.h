#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

#include <numbers>

namespace tenon {

template <class T = double>
struct HeldLagParams {
  double time_constant = 0.004;       ///< [s]; the cut-off frequency is 1 / (2 pi time_constant) Hz
  T initial = internal::Zeroed<T>();  ///< y at t = 0 [unit]
  Rate rate = Hz(1000);               ///< rate at which u is sampled
  std::string unit = "";              ///< unit of input and output
  std::string elements = "";          ///< names of the elements
  void Validate() const {
    Demand(internal::IsFinite(initial), "initial must be finite");
    if constexpr (internal::VectorOfRunTimeSize<T>)
      Demand(initial.size() > 0, "initial must have the size of the signal");
  }
};

/// Response of a HeldLag since its last tick, from one value to another.
template <class T>
struct HeldLagPart {
  double since = 0;  ///< [s]
  T from = internal::Zeroed<T>();
  T to = internal::Zeroed<T>();
  static FieldList Fields() {
    return {{"since", &HeldLagPart::since, "s"}, {"from", &HeldLagPart::from}, {"to", &HeldLagPart::to}};
  }
};

/// A first-order lag of a signal that is held between ticks, such as a current controller that follows its
/// set-point. It uses the closed-form solution, so it adds no continuous state and a short lag does not limit
/// the step size.
///
///     T dy/dt = u[k] - y   for k h < t <= (k + 1) h,   y(0) = initial:
///     y(t) = u[k] + (y(k h) - u[k]) exp(-(t - k h) / T)
///
/// y is continuous in time and does not depend on the present input, so the block breaks loops. Where u
/// jumps, y bends at the next tick. Use LowPassFilter for signals that are not held. T is double, Vec<N> or a
/// vector of run-time size, which `initial` sets. Throws ParameterError if the time constant is not positive
/// and finite.
template <class T = double>
class HeldLag final : public LeafSystem<HeldLagParams<T>> {
  static_assert(internal::DoubleOrMatrix<T> || internal::VectorOfRunTimeSize<T>,
                "HeldLag: T is double, a Vec<N> or a vector of run-time size.");

 public:
  using LeafSystem<HeldLagParams<T>>::LeafSystem;
  using LeafSystem<HeldLagParams<T>>::params;
  using Part = HeldLagPart<T>;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  Parameter<double> time_constant{
      this, {"time_constant", "s"}, params.time_constant, "time constant of the lag", Range().Positive()};
  DiscreteState<Part> part{this, "part", Part{.from = params.initial, .to = params.initial}};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  params.initial,
                  Uses(this->time, part, time_constant),
                  [](double t, const Part& p, double tau, T* y_out) {
                    *y_out = p.to + std::exp((p.since - t) / tau) * (p.from - p.to);
                  }};
  Update<Part> next{part, Sampled{params.rate}, Uses(this->time, y, u),
                    [](double t, const T& y_now, const T& u_now, Part* next_out) {
                      next_out->since = t;
                      next_out->from = y_now;
                      next_out->to = u_now;
                    }};
};

/// Time constant [s] of a lag with a bandwidth in Hz, the frequency at which its gain is 1/sqrt(2).
inline double LagOfBandwidth(double hertz) {
  return 1 / (2 * std::numbers::pi * hertz);
}

}  // namespace tenon
