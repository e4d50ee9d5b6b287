#pragma once

#include <cmath>
#include <string>

#include <tenon/systems/framework/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct GainParams {
  double gain = 1;          ///< [unit of y / unit of u]
  std::string u_unit = "";  ///< of the input
  std::string y_unit = "";  ///< of the output
  void Validate() const { Demand(std::isfinite(gain), "gain must be finite"); }
};

/// A factor:
///
///     y = k u
///
///     | port | kind   | size | unit   |
///     | u    | input  | T    | u_unit |
///     | y    | output | T    | y_unit |
///
/// T is double or Vec<N>. Throws ParameterError if the gain is not finite.
template <internal::DoubleOrMatrix T = double>
class Gain final : public LeafSystem<GainParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, {"u", params.u_unit}};
  OutputPort<T> y{this, {"y", params.y_unit}, Uses(u), [this](const T& u) -> T { return params.gain * u; }};
};

}  // namespace tenon
