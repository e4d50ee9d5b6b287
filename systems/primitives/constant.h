#pragma once

#include <string>

#include <tenon/systems/framework/state.h>

namespace tenon {

template <class T = double>
struct ConstantParams {
  T value = internal::Zeroed<T>();  ///< [unit]
  std::string unit = "";
};

/// A value that never changes.
///
///     | port | kind   | size | unit |
///     | y    | output | T    | unit |
///
/// T is any copyable type.
template <class T = double>
class ConstantSource final : public LeafSystem<ConstantParams<T>> {
 public:
  using LeafSystem<ConstantParams<T>>::LeafSystem;
  using LeafSystem<ConstantParams<T>>::params;
  OutputPort<T> y{
      this, {"y", params.unit}, params.value, Uses(), [this]() -> const T& { return params.value; }};
};

}  // namespace tenon
