#pragma once

#include <concepts>
#include <type_traits>

#include <tenon/systems/framework/signal.h>

namespace tenon::internal {

/// What the primitives carry: a double, a Vec<N>, or another matrix of fixed size.
template <class T>
concept DoubleOrMatrix = std::same_as<T, double> ||
    (InlineMatrix<T>&& std::same_as<typename T::Scalar, double>);

/// A T with every number in it `number`.
template <DoubleOrMatrix T>
T Filled(double number) {
  if constexpr (std::same_as<T, double>) {
    return number;
  } else {
    return T::Constant(number);
  }
}

/// Applies `function` to the numbers of the values, element by element, in order.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
T Elementwise(F function, const T& first, const More&... more) {
  if constexpr (std::same_as<T, double>) {
    return function(first, more...);
  } else {
    T result = first;
    for (Eigen::Index i = 0; i < first.size(); ++i)
      result.data()[i] = function(first.data()[i], more.data()[i]...);
    return result;
  }
}

/// Whether `condition` holds for all numbers of the values, element by element.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
bool Everywhere(F condition, const T& first, const More&... more) {
  bool all = true;
  Elementwise(
      [&](double a, auto... b) {
        all &= condition(a, b...);
        return a;
      },
      first, more...);
  return all;
}

}  // namespace tenon::internal
