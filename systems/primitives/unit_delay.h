#pragma once

#include <tenon/systems/framework/block/state.h>

namespace tenon {

template <class T = double>
struct UnitDelayParams {
  T initial = internal::Zeroed<T>();  ///< y at the first tick [unit]
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
};

/// A delay by one sample, which models computation time and breaks loops of sampled blocks:
///
///     y[n + 1] = u[n],   y[0] = initial
///
/// T is any copyable type. The output does not depend on the present input.
template <class T = double>
class UnitDelay final : public LeafSystem<UnitDelayParams<T>> {
 public:
  using LeafSystem<UnitDelayParams<T>>::LeafSystem;
  using LeafSystem<UnitDelayParams<T>>::params;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  DiscreteState<T> x{this, {"x", params.unit, params.elements}, params.initial};
  OutputPort<T> y{this,    {"y", params.unit, params.elements},     params.initial, Sampled{params.rate},
                  Uses(x), [](const T& v) -> const T& { return v; }};
  Update<T> next{x, Sampled{params.rate}, Uses(u), [](const T& v) -> const T& { return v; }};
};

}  // namespace tenon
