#pragma once

#include <tenon/systems/framework/block/state.h>

namespace tenon {

struct ZeroOrderHoldParams {
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
};

/// Samples its input and holds it. With h the period:
///
///     y(t) = u(n h)   for n h <= t < (n + 1) h
///
/// T is any copyable type. The block has feedthrough at its ticks and does not break loops.
template <class T = double>
class ZeroOrderHold final : public LeafSystem<ZeroOrderHoldParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, Sampled{params.rate}, Uses(u), [](const T& v) -> const T& {
        return v;
      }};
};

}  // namespace tenon
