#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct SineParams {
  T amplitude = internal::Filled<T>(1);          ///< [unit]
  T angular_frequency = internal::Filled<T>(1);  ///< [rad/s]
  T phase = internal::Filled<T>(0);              ///< [rad]
  T offset = internal::Filled<T>(0);             ///< [unit]
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
};

/// A sine with its derivatives, element by element:
///
///     y = offset + a sin(w t + phase),   dy = a w cos(w t + phase),   ddy = -a w^2 sin(w t + phase)
///
/// T is double or Vec<N>: phases of 0 and pi/2 make a circle. The phase is counted from t = 0, so changing a
/// frequency during a run makes y jump. Throws ParameterError if a number is not finite.
template <internal::DoubleOrMatrix T = double>
class Sine final : public LeafSystem<SineParams<T>> {
 public:
  using LeafSystem<SineParams<T>>::LeafSystem;
  using LeafSystem<SineParams<T>>::params;
  Parameter<T> amplitude{this,
                         {"amplitude", params.unit, params.elements},
                         params.amplitude,
                         "amplitude of y",
                         Range().Finite()};
  Parameter<T> angular_frequency{this,
                                 {"angular_frequency", "rad/s", params.elements},
                                 params.angular_frequency,
                                 "frequency of y",
                                 Range().Finite()};
  Parameter<T> phase{
      this, {"phase", "rad", params.elements}, params.phase, "phase of y at t = 0", Range().Finite()};
  Parameter<T> offset{
      this, {"offset", params.unit, params.elements}, params.offset, "mean of y", Range().Finite()};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(this->time, amplitude, angular_frequency, phase, offset),
                  [](double t, const T& a, const T& w, const T& phi, const T& offset_now) -> T {
                    return offset_now + Derivative(t, a, w, phi, 0);
                  }};
  OutputPort<T> dy{
      this,
      {"dy", internal::Per(params.unit, "s"), params.elements},
      Uses(this->time, amplitude, angular_frequency, phase),
      [](double t, const T& a, const T& w, const T& phi) -> T { return Derivative(t, a, w, phi, 1); }};
  OutputPort<T> ddy{
      this,
      {"ddy", internal::Per(params.unit, "s^2"), params.elements},
      Uses(this->time, amplitude, angular_frequency, phase),
      [](double t, const T& a, const T& w, const T& phi) -> T { return Derivative(t, a, w, phi, 2); }};

 private:
  static T Derivative(double t, const T& amplitude, const T& angular_frequency, const T& phase, int order) {
    const auto value = [t, order](double a, double w, double phi_i) {
      const double angle = w * t + phi_i;
      return order == 0   ? a * std::sin(angle)
             : order == 1 ? a * w * std::cos(angle)
                          : -a * w * w * std::sin(angle);
    };
    return internal::Elementwise(value, amplitude, angular_frequency, phase);
  }
};

}  // namespace tenon
