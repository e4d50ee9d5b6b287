#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

#include <string>

namespace tenon {

struct GainParams {
  double gain = 1;            ///< [unit of y / unit of u]
  std::string u_unit = "";    ///< unit of the input
  std::string y_unit = "";    ///< unit of the output
  std::string elements = "";  ///< names of the elements of u and y
};

/// A multiplication by a scalar:
///
///     y = gain u
///
///     | port | kind      | size   | unit            |
///     | u    | input     | T      | u_unit          |
///     | gain | Parameter | double | y_unit / u_unit |
///     | y    | output    | T      | y_unit          |
///
/// T is double or Vec<N>. Throws ParameterError if the gain is not finite.
template <internal::DoubleOrMatrix T = double>
class Gain final : public LeafSystem<GainParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<double> gain{this, "gain", params.gain, "factor in unit of y / unit of u", Range().Finite()};
  InputPort<T> u{this, {"u", params.u_unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.y_unit, params.elements}, Uses(gain, u), [](double gain, const T& u) -> T {
        return gain * u;
      }};
};

}  // namespace tenon
