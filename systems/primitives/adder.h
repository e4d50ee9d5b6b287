#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct AdderParams {
  internal::Weights weights = {1, 1};  ///< one per input, for example {1, -1}
  std::string unit = "";               ///< unit of inputs and output
  std::string elements = "";           ///< names of the elements
  void Validate() const {
    Demand(!weights.empty(), "weights must not be empty: give one weight per input");
    Demand(internal::IsFinite(weights), "weights must be finite");
  }
};

/// A weighted sum with one input per weight:
///
///     y = w_0 u_0 + w_1 u_1 + …
///
/// T is double or Vec<N>. Throws ParameterError if there are no weights or one is not finite, and RunError
/// during a run if the number of weights differs from the number of inputs.
template <internal::DoubleOrMatrix T = double>
class Adder final : public LeafSystem<AdderParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<internal::Weights> weights{this, "weights", params.weights, "one per input"};
  InputPorts<T> u{this, {"u", params.unit, params.elements}, params.weights.size()};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(weights, u),
                  [](const internal::Weights& weights_now, const Inputs<T>& u_now) -> T {
                    if (weights_now.size() != u_now.size()) {
                      throw RunError("there are " + std::to_string(weights_now.size()) + " weights, but " +
                                     std::to_string(u_now.size()) + " inputs: set one weight per input");
                    }
                    const double* weight = weights_now.data();
                    T sum = weight[0] * u_now[0];
                    for (std::size_t i = 1; i < u_now.size(); ++i) sum += weight[i] * u_now[i];
                    return sum;
                  }};
};

}  // namespace tenon
