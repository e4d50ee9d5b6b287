#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdlib>
#include <type_traits>
#include <utility>

namespace tenon::internal {

/// Body of a conversion that is never evaluated. Clang requires one for types without linkage.
template <class T>
[[noreturn]] T Never() {
  std::abort();
}

/// Converts to the type of any member, and to a matrix only if `IsMatrix`. Never evaluated.
///
/// An optional must be initialised by AnyMember<false>: with a conversion to matrices, compilers would
/// instantiate a constructor of std::optional<Matrix> that does not compile.
template <bool IsMatrix>
struct AnyMember {
  template <class Member>
  requires(IsMatrix || !std::is_base_of_v<Eigen::EigenBase<Member>, Member>) operator Member()
      const {  // NOLINT(google-explicit-constructor)
    return Never<Member>();
  }
};

/// Converts to a base of T.
template <class T>
struct AnyBase {
  template <class Base>
  requires(std::is_base_of_v<Base, T> && !std::is_same_v<Base, T>) operator Base()
      const {  // NOLINT(google-explicit-constructor)
    return Never<Base>();
  }
};

/// A list of initialisers; each is marked if it initialises a matrix.
template <bool... IsMatrix>
struct Initializers {
  static constexpr std::size_t kCount = sizeof...(IsMatrix);
  template <class T>
  static constexpr bool kTakenBy = requires {
    T{AnyMember<IsMatrix>{}...};
  };

  using Matrix = Initializers<IsMatrix..., true>;
  template <std::size_t... I>
  static Initializers<IsMatrix..., (static_cast<void>(I), false)...> MoreBy(std::index_sequence<I...>);
  template <std::size_t N>
  using More = decltype(MoreBy(std::make_index_sequence<N>{}));
};

/// Number of further non-matrix initialisers that T takes, in [Low, High).
template <class T, class Known, std::size_t Low, std::size_t High>
consteval std::size_t CountMore() {
  if constexpr (High - Low == 1) {
    return Low;
  } else {
    constexpr std::size_t kMiddle = Low + (High - Low) / 2;
    if constexpr (Known::template More<kMiddle>::template kTakenBy<T>) {
      return CountMore<T, Known, kMiddle, High>();
    } else {
      return CountMore<T, Known, Low, kMiddle>();
    }
  }
}
template <class T, class Known, std::size_t Low = 0>
consteval std::size_t CountMoreFrom() {
  constexpr std::size_t kHigh = Low == 0 ? 2 : 2 * Low;
  if constexpr (Known::template More<kHigh>::template kTakenBy<T>) {
    return CountMoreFrom<T, Known, kHigh>();
  } else {
    return CountMore<T, Known, Low, kHigh>();
  }
}

template <class T, class Known>
consteval int CountInitializers() {
  using More = typename Known::template More<CountMoreFrom<T, Known>()>;
  if constexpr (More::Matrix::template kTakenBy<T>) {
    return CountInitializers<T, typename More::Matrix>();
  } else {
    return More::kCount;
  }
}

/// Number of members of T, with each item of a C array counted; -1 if it cannot be known because T is not an
/// aggregate or has bases.
template <class T>
consteval int CountMembers() {
  if constexpr (!std::is_aggregate_v<T> || !std::is_default_constructible_v<T>) {
    return -1;
  } else if constexpr (requires { T{AnyBase<T>{}}; }) {
    return -1;
  } else {
    return CountInitializers<T, Initializers<>>();
  }
}

}  // namespace tenon::internal
