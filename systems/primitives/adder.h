#pragma once

#include <string>
#include <vector>

#include <tenon/systems/framework/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct AdderParams {
  std::vector<double> weights = {1, 1};  ///< one per input: {1, -1} subtracts
  std::string unit = "";                 ///< of the inputs and of the output
  void Validate() const {
    Demand(!weights.empty(), "weights must not be empty: give one weight per input");
    Demand(internal::IsFinite(weights), "weights must be finite");
  }
};

/// A weighted sum of as many inputs as there are weights:
///
///     y = w_0 u_0 + w_1 u_1 + …
///
///     | port        | kind   | size   | unit |
///     | u[0], u[1]… | input  | T each | unit |
///     | y           | output | T      | unit |
///
/// T is double or Vec<N>. Throws ParameterError if there are no weights or one is not finite.
template <internal::DoubleOrMatrix T = double>
class Adder final : public LeafSystem<AdderParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<T> u{this, {"u", params.unit}, params.weights.size()};
  OutputPort<T> y{this, {"y", params.unit}, Uses(u), [this](const Inputs<T>& u) -> T {
                    T sum = params.weights[0] * u[0];
                    for (std::size_t i = 1; i < u.size(); ++i) sum += params.weights[i] * u[i];
                    return sum;
                  }};
};

}  // namespace tenon
