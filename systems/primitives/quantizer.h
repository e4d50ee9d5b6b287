#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct QuantizerParams {
  T step = internal::Filled<T>(1);  ///< [unit]
  std::string unit = "";            ///< unit of input and output
  std::string elements = "";        ///< names of the elements
};

/// Rounds to the nearest multiple of a step, like an encoder or an analogue-to-digital converter, element by
/// element:
///
///     y = step round(u / step)
///
/// T is double or Vec<N>. Halves are rounded away from zero. The jumps are a Kink: each ends an integrator
/// step if a derivative depends on y. Throws ParameterError if a step is not positive or not finite.
template <internal::DoubleOrMatrix T = double>
class Quantizer final : public LeafSystem<QuantizerParams<T>> {
 public:
  using LeafSystem<QuantizerParams<T>>::LeafSystem;
  using LeafSystem<QuantizerParams<T>>::params;
  Parameter<T> step{this,
                    {"step", params.unit, params.elements},
                    params.step,
                    "difference between successive values of y",
                    Range().Positive()};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, Uses(u, step), [](const T& u_now, const T& step_now) -> T {
        return internal::Elementwise(
            [](double u_i, double step_i) { return step_i * std::round(u_i / step_i); }, u_now, step_now);
      }};
  Kink kink{this, "kink", Uses(u, step), [](const T& u_now, const T& step_now) {
              return internal::PieceOf(
                  [](double u_i, double step_i) {
                    return std::isfinite(u_i) ? std::clamp(std::round(u_i / step_i), -1e15, 1e15) : 0.0;
                  },
                  u_now, step_now);
            }};
};

}  // namespace tenon
