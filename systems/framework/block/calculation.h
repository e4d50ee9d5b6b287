#pragma once

#include <tenon/systems/framework/block/source.h>
#include <tenon/systems/framework/types/internal/fnv1a.h>

namespace tenon {

/// The current time [s], as a prerequisite: `Uses(time, x)`.
struct Time {
  using Argument = const double&;
  void AppendTo(std::vector<internal::Slot>& slots) const { slots.push_back({internal::Slot::What::kTime}); }
};

namespace internal {

template <class>
inline constexpr bool kFalse = false;

/// Types that Uses accepts; `Argument` is the type that the calculation's function receives.
template <class S>
concept Usable = requires {
  typename S::Argument;
};
struct Refused {};  ///< argument type after Uses has reported an error

inline bool Exists(const Time&) {
  return true;  // a member of the base class, which is constructed first
}
inline bool Exists(const Declared& member) {
  return Declared::IsDeclared(member);
}

/// Distinguishes two functions where the compiler does not: Clang 14 gives all lambdas of a class declared
/// inside a function one name, and templates instantiated with them one body. Evaluated where the calculation
/// is declared and again in that body.
#ifdef __clang__
template <class F>
constexpr std::uint64_t HashOf() {
  Fnv1a hash;
  hash.Add(__PRETTY_FUNCTION__);
  return hash.value();
}
template <class F>
using TagOf = std::integral_constant<std::uint64_t, HashOf<F>()>;
#else
template <class F>
using TagOf = std::integral_constant<std::uint64_t, 0>;
#endif
template <class S>
struct ArgumentOf {
  using Type = Refused;
};
template <Usable S>
struct ArgumentOf<S> {
  using Type = typename S::Argument;
};

}  // namespace internal

/// The declared prerequisites of a calculation, made by Uses. `Arguments` are the parameters of its function.
template <class... Arguments>
struct UsesList {
  std::vector<internal::Slot> slots;
  int undeclared = 0;  ///< the first one that does not exist yet, counted from 1; 0 if all exist
};

/// Declares the values that a calculation uses. Its function receives exactly these values, in this order:
/// inputs, outputs, states, shared values and `time` as const references, scratch and random streams as
/// references, InputPorts as a list. All must belong to the calculation's own block.
template <class... S>
auto Uses(const S&... sources) {
  UsesList<typename internal::ArgumentOf<S>::Type...> uses;
  if constexpr ((internal::Usable<S> && ...)) {
    uses.slots.reserve(sizeof...(S));
    int index = 0;
    const auto append = [&](const auto& source) {
      ++index;
      if (!internal::Exists(source)) {
        if (uses.undeclared == 0) uses.undeclared = index;
      } else {
        source.AppendTo(uses.slots);
      }
    };
    (append(sources), ...);
  } else {
    static_assert(internal::kFalse<UsesList<S...>>,
                  "Uses(...) takes ports, states, shared values, scratch, random streams and `time`. "
                  "Constants in `params` need not be declared.");
  }
  return uses;
}

/// The sources of a calculation declared with UsesAtRunTime.
class Reads {
 public:
  Reads(std::byte* memory, const internal::Offset* list, const Source& calculation)
      : memory_(memory), offsets_(list + 1), calculation_(calculation) {}
  /// The value of a port or state. Throws RunError that names the calculation and the source if it was not
  /// declared.
  template <class S>
  typename S::Argument operator[](const S& source) const {
    return *reinterpret_cast<std::remove_reference_t<typename S::Argument>*>(memory_ + Find(source));
  }

 private:
  internal::Offset Find(const Source& source) const;
  std::byte* memory_;
  const internal::Offset* offsets_;
  const Source& calculation_;
};

/// Alternative to Uses for blocks whose ports are known only at run time. The function receives a
/// `const Reads&` and looks the values up in it; reading an undeclared source throws RunError.
UsesList<Reads> UsesAtRunTime(const std::vector<const Source*>& sources);

namespace internal {

template <class A>
decltype(auto) LoadArgument(const Closure& closure, std::byte* memory, const Offset* row, std::size_t i) {
  if constexpr (std::is_reference_v<A>) {
    (void)closure;
    return *std::launder(reinterpret_cast<std::remove_reference_t<A>*>(memory + row[1 + i]));
  } else {
    return A(memory, row + row[1 + i], *closure.calculation);
  }
}

/// Signature of a member function; `kIs` is false for any other callable.
template <class F>
struct MemberFunction {
  static constexpr bool kIs = false, kConst = true;
};
template <class R, class C, class... P>
struct MemberFunction<R (C::*)(P...) const> {
  static constexpr bool kIs = true, kConst = true;
  using Class = C;
  using Signature = void(std::remove_cvref_t<P>...);
};
template <class R, class C, class... P>
struct MemberFunction<R (C::*)(P...)> {
  static constexpr bool kIs = true, kConst = false;
};

template <class T>
inline constexpr bool kIsUses = false;
template <class... A>
inline constexpr bool kIsUses<UsesList<A...>> = true;
template <class F>
concept Function = MemberFunction<F>::kIs || std::is_function_v<F> || requires {
  &F::operator();
};
/// True for the arguments of a calculation if they end with its function but lack Uses(...).
template <class... Args>
inline constexpr bool kLacksUses = false;
template <class First, class... Rest>
inline constexpr bool kLacksUses<First, Rest...> = !kIsUses<First> && kLacksUses<Rest...>;
template <class Last>
inline constexpr bool kLacksUses<Last> = Function<Last>;
template <class F>
void ReportMissingUses() {
  static_assert(
      kFalse<F>,
      "Uses(...) is missing before the function: it names the values that the function receives, in "
      "the order of its parameters; Uses() if there are none.");
}

/// Target of a calculation that is run for its side effect. A muted one is not run.
struct Published {
  bool muted = false;
  static FieldList Fields() { return {{"muted", &Published::muted}}; }
};

template <class T>
inline constexpr bool kHasRunTimeSize = false;
template <EigenMatrix T>
inline constexpr bool kHasRunTimeSize<T> = T::SizeAtCompileTime == Eigen::Dynamic;

/// Throws RunError that names both sizes, and the port that declares the other one.
[[noreturn]] void ThrowOtherSize(const Closure& closure, std::ptrdiff_t rows, std::ptrdiff_t cols);

/// The code that a compiled diagram runs for one calculation. A function either returns the Target or, for
/// large values, takes a `Target*` after its arguments and fills it in place. A function whose target is
/// Published returns nothing.
template <class Target, class F, class... A>
struct Calculation {
  using Traits = MemberFunction<F>;

  /// Parameter types must match exactly, so that a wrong connection gives one readable error; Eigen's
  /// implicit conversions would give pages.
  static constexpr bool Returns() {
    if constexpr (Traits::kIs) {
      return std::is_same_v<typename Traits::Signature, void(std::remove_cvref_t<A>...)>;
    } else {
      return std::is_invocable_v<const F&, A...>;
    }
  }
  static constexpr bool FillsInPlace() {
    if constexpr (Traits::kIs) {
      return std::is_same_v<typename Traits::Signature, void(std::remove_cvref_t<A>..., Target*)>;
    } else {
      return std::is_invocable_v<const F&, A..., Target*>;
    }
  }

  /// True for a lambda that would fit if it were not `mutable`.
  static constexpr bool IsMutable() {
    if constexpr (Traits::kIs) {
      return false;
    } else {
      return !Returns() && !FillsInPlace() &&
             (std::is_invocable_v<F&, A...> || std::is_invocable_v<F&, A..., Target*>);
    }
  }

  /// True if the function returns the Target, or any scalar for a scalar Target.
  static constexpr bool ReturnsTarget() {
    using Result =
        std::remove_cvref_t<decltype(Call(std::declval<const ClosureOf<F>&>(), std::declval<A>()...))>;
    return std::is_same_v<Result, Target> || (Scalar<Result> && Scalar<Target>) ||
           (std::is_void_v<Result> && std::is_same_v<Target, Published>);
  }

  template <class... Values>
  static decltype(auto) Call(const ClosureOf<F>& closure, Values&&... values) {
    if constexpr (Traits::kIs) {
      const auto* self = static_cast<const typename Traits::Class*>(closure.self);
      return (self->*closure.function)(std::forward<Values>(values)...);
    } else {
      return closure.function(std::forward<Values>(values)...);
    }
  }

  template <std::size_t... I>
  static constexpr Thunk Run(std::index_sequence<I...>) {
    return [](const Closure* const* closures, const Offset* row, std::byte* memory, std::size_t count,
              std::size_t* current, [[maybe_unused]] std::size_t carried) {
      if constexpr ((CanCarry<A>() || ...)) {
        if ((RunCarrying<I, A, I...>(closures, row, memory, count, current, carried) || ...)) return;
      }
      for (std::size_t i = 0; i < count; ++i, row += 1 + sizeof...(A)) {
        *current = i;
        const auto& closure = static_cast<const ClosureOf<F>&>(*closures[i]);
        auto* target = std::launder(reinterpret_cast<Target*>(memory + row[0]));
        if constexpr (std::is_same_v<Target, Published>) {
          if (!target->muted) Call(closure, LoadArgument<A>(closure, memory, row, I)...);
        } else if constexpr (Returns()) {
          *target = Call(closure, LoadArgument<A>(closure, memory, row, I)...);
        } else {
          Call(closure, LoadArgument<A>(closure, memory, row, I)..., target);
        }
        if constexpr (kHasRunTimeSize<Target>) {
          if (closure.rows >= 0 && (target->rows() != closure.rows || target->cols() != closure.cols))
            ThrowOtherSize(closure, target->rows(), target->cols());
        }
      }
    };
  }

 private:
  /// True if an argument can be kept in a register from one call to the next, which makes a chain of gains as
  /// fast as its multiplications. Each such argument needs its own loop, so only for few arguments.
  template <class Argument>
  static constexpr bool CanCarry() {
    return std::is_same_v<Target, double> && std::is_same_v<Argument, const double&> && sizeof...(A) <= 3 &&
           Returns();
  }

  /// Runs the calculations with argument K kept in a register and returns true, if K is the carried argument.
  template <std::size_t K, class Argument, std::size_t... I>
  static bool RunCarrying(const Closure* const* closures, const Offset* row, std::byte* memory,
                          std::size_t count, std::size_t* current, std::size_t carried) {
    if constexpr (CanCarry<Argument>()) {
      if (carried != K) return false;
      double value = LoadArgument<Argument>(*closures[0], memory, row, K);
      for (std::size_t i = 0; i < count; ++i, row += 1 + sizeof...(A)) {
        *current = i;
        const auto& closure = static_cast<const ClosureOf<F>&>(*closures[i]);
        value = Call(closure, TakeArgument<A, I == K>(value, closure, memory, row, I)...);
        *std::launder(reinterpret_cast<double*>(memory + row[0])) = value;
      }
      return true;
    }
    return false;
  }
  template <class Argument, bool kIsCarried>
  static decltype(auto) TakeArgument([[maybe_unused]] const double& carried, const Closure& closure,
                                     std::byte* memory, const Offset* row, std::size_t i) {
    if constexpr (kIsCarried) {
      return static_cast<const double&>(carried);
    } else {
      return LoadArgument<Argument>(closure, memory, row, i);
    }
  }
};

}  // namespace internal
}  // namespace tenon
