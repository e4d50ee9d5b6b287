#pragma once

#include <tenon/systems/block.h>

namespace tenon {

template <class T = double>
struct ConstantParams {
  T value = internal::Zeroed<T>();  ///< [unit]
  std::string unit = "";
  std::string elements = "";  ///< names of the elements
};

/// A constant value, which can be changed between advances of a run: `context.Set(constant.value, 3)`.
///
/// T is any copyable type.
template <class T = double>
class ConstantSource final : public LeafSystem<ConstantParams<T>> {
 public:
  using LeafSystem<ConstantParams<T>>::LeafSystem;
  using LeafSystem<ConstantParams<T>>::params;
  Parameter<T> value{this, {"value", params.unit, params.elements}, params.value, "value of the output"};
  OutputPort<T> y{
      this, {"y", params.unit, params.elements}, params.value, Uses(value), [](const T& v) -> const T& {
        return v;
      }};
};

}  // namespace tenon
