#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon::internal {

/// Value types of most primitives: a double, a Vec<N>, or another matrix of fixed size.
template <class T>
concept DoubleOrMatrix = std::same_as<T, double> ||
    (InlineMatrix<T>&& std::same_as<typename T::Scalar, double>);

/// A vector of doubles whose size is known only at run time, with any alignment.
template <class T>
concept VectorOfRunTimeSize = std::derived_from<T, Eigen::PlainObjectBase<T>> &&
                                  T::RowsAtCompileTime == Eigen::Dynamic&& T::ColsAtCompileTime == 1 &&
                              std::same_as<typename T::Scalar, double>;

/// Value types of noise: those of most primitives, and structs that describe themselves.
template <class T>
concept DoublesInside = DoubleOrMatrix<T> || HasFields<T>;

/// A T in which every number is `number`.
template <DoubleOrMatrix T>
T Filled(double number) {
  if constexpr (std::same_as<T, double>) {
    return number;
  } else {
    return T::Constant(number);
  }
}

/// A T in which every number is `number`, or a struct in which every number is zero.
template <DoublesInside T>
T FilledOrZero([[maybe_unused]] double number) {
  if constexpr (DoubleOrMatrix<T>) {
    return Filled<T>(number);
  } else {
    return Zeroed<T>();
  }
}

/// Applies `function` to the elements of the values, one by one and in order.
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

/// True if `condition` holds for all elements of the values.
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

/// An index, for a Kink, of the pieces on which the elements of the values are; it changes if one of them
/// does.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
std::int64_t PieceOf(F piece, const T& first, const More&... more) {
  if constexpr (std::same_as<T, double>) {
    return static_cast<std::int64_t>(piece(first, more...));
  } else {
    std::uint64_t combined = 0;
    for (Eigen::Index i = 0; i < first.size(); ++i) {
      const auto each = static_cast<std::int64_t>(piece(first.data()[i], more.data()[i]...));
      // An odd factor keeps the difference that any one element makes in the low bits.
      combined = combined * 1000003 + static_cast<std::uint64_t>(each);
    }
    return static_cast<std::int64_t>(combined & ((std::uint64_t{1} << 53) - 1));  // a double holds 53 bits
  }
}

inline double* DoublesAt(void* value, std::size_t offset) {
  return reinterpret_cast<double*>(static_cast<std::byte*>(value) + offset);
}
inline const double* DoublesAt(const void* value, std::size_t offset) {
  return reinterpret_cast<const double*>(static_cast<const std::byte*>(value) + offset);
}

/// Calls `visit(double&, …)` for each double of the values, in order. Their type must have a fixed size.
template <class F, class T, class... More>
void ForEachDouble(F visit, T& first, More&... more) {
  for (const ScalarRun& run : TypeInfoOf<std::remove_const_t<T>>().runs) {
    if (run.kind != ScalarKind::kDouble) continue;
    for (std::size_t i = 0; i < run.count; ++i)
      visit(DoublesAt(&first, run.offset)[i], DoublesAt(&more, run.offset)[i]...);
  }
}

}  // namespace tenon::internal
