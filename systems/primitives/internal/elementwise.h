#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace tenon::internal {

/// What the primitives carry: a double, a Vec<N>, or another matrix of fixed size.
template <class T>
concept DoubleOrMatrix = std::same_as<T, double> ||
    (InlineMatrix<T>&& std::same_as<typename T::Scalar, double>);

/// A vector of doubles whose size is known at run time, with whatever alignment.
template <class T>
concept VectorOfRunTimeSize = std::derived_from<T, Eigen::PlainObjectBase<T>> &&
                                  T::RowsAtCompileTime == Eigen::Dynamic&& T::ColsAtCompileTime == 1 &&
                              std::same_as<typename T::Scalar, double>;

/// What noise is put on: those, and structs that describe themselves.
template <class T>
concept DoublesInside = DoubleOrMatrix<T> || HasFields<T>;

/// A T with every number in it `number`.
template <DoubleOrMatrix T>
T Filled(double number) {
  if constexpr (std::same_as<T, double>) {
    return number;
  } else {
    return T::Constant(number);
  }
}

/// The same; a struct is zero.
template <DoublesInside T>
T FilledOrZero([[maybe_unused]] double number) {
  if constexpr (DoubleOrMatrix<T>) {
    return Filled<T>(number);
  } else {
    return Zeroed<T>();
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

/// One number for the pieces on which all elements of the values are, for a Kink: it changes if one does.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
std::int64_t PieceOf(F piece, const T& first, const More&... more) {
  if constexpr (std::same_as<T, double>) {
    return static_cast<std::int64_t>(piece(first, more...));
  } else {
    std::uint64_t combined = 0;
    for (Eigen::Index i = 0; i < first.size(); ++i) {
      const auto each = static_cast<std::int64_t>(piece(first.data()[i], more.data()[i]...));
      combined = combined * 1000003 + static_cast<std::uint64_t>(each);
    }
    return static_cast<std::int64_t>(combined >> 12);  // a double holds 53 bits exactly
  }
}

inline double* DoublesAt(void* value, std::size_t offset) {
  return reinterpret_cast<double*>(static_cast<std::byte*>(value) + offset);
}
inline const double* DoublesAt(const void* value, std::size_t offset) {
  return reinterpret_cast<const double*>(static_cast<const std::byte*>(value) + offset);
}

/// Calls `visit(double&, …)` for all doubles of the values, one of each, in order. Their type must be fixed.
template <class F, class T, class... More>
void ForEachDouble(F visit, T& first, More&... more) {
  for (const ScalarRun& run : TypeInfoOf<std::remove_const_t<T>>().runs) {
    if (run.kind != ScalarKind::kDouble) continue;
    for (std::size_t i = 0; i < run.count; ++i)
      visit(DoublesAt(&first, run.offset)[i], DoublesAt(&more, run.offset)[i]...);
  }
}

}  // namespace tenon::internal
