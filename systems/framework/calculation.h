#pragma once

#include <functional>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <tenon/systems/framework/source.h>

namespace tenon {

/// The current time [s], as a prerequisite: `Uses(time, x)`.
struct Time {
  using Argument = const double&;
};

/// How a calculation gets the value of a declared source. `Argument` is what its function receives.
template <class S>
struct SourceHandle {
  const S* source;
  using Argument = typename S::Argument;
  Argument Load(std::byte* memory, const internal::Offset*& cursor) const {
    return *std::launder(reinterpret_cast<std::remove_reference_t<Argument>*>(memory + *cursor++));
  }
  void Append(std::vector<Source::Slot>& slots) const {
    slots.push_back({Source::Slot::What::kSource, source});
  }
};

template <>
struct SourceHandle<Time> {
  const Time* source;
  using Argument = const double&;
  Argument Load(std::byte* memory, const internal::Offset*&) const {
    return *reinterpret_cast<const double*>(memory);  // time lies at the start of every context
  }
  void Append(std::vector<Source::Slot>& slots) const { slots.push_back({Source::Slot::What::kTime}); }
};

/// The declared prerequisites of a calculation, made by Uses.
template <class... Handles>
struct UsesList {
  std::tuple<Handles...> handles;
};

/// Declares what a calculation uses: its function receives exactly these values, in this order. Inputs,
/// outputs, states, shared values and `time` arrive as const references, scratch and random streams as
/// references, InputPorts as a list. All must belong to the calculation's own block.
template <class... S>
UsesList<SourceHandle<S>...> Uses(const S&... sources) {
  return {std::tuple<SourceHandle<S>...>{SourceHandle<S>{&sources}...}};
}

/// What a calculation declared with UsesAtRunTime reads its sources from.
class Reads {
 public:
  Reads(std::byte* memory, const internal::Offset* offsets, const std::vector<const Source*>& declared)
      : memory_(memory), offsets_(offsets), declared_(declared) {}
  /// The value of a port or state; throws RunError, naming both, if it was not declared.
  template <class S>
  typename S::Argument operator[](const S& source) const {
    return *reinterpret_cast<std::remove_reference_t<typename S::Argument>*>(memory_ + Find(source));
  }

 private:
  internal::Offset Find(const Source& source) const;
  std::byte* memory_;
  const internal::Offset* offsets_;
  const std::vector<const Source*>& declared_;
};

/// The handle of a list of sources that is only known at run time.
class RuntimeSources {
 public:
  explicit RuntimeSources(std::vector<const Source*> sources) : sources_(std::move(sources)) {}
  using Argument = Reads;
  Argument Load(std::byte* memory, const internal::Offset*& cursor) const {
    const internal::Offset* offsets = cursor;
    cursor += sources_.size();
    return Reads(memory, offsets, sources_);
  }
  void Append(std::vector<Source::Slot>& slots) const {
    for (const Source* source : sources_) slots.push_back({Source::Slot::What::kSource, source});
  }

 private:
  std::vector<const Source*> sources_;
};

/// Second choice beside Uses, for blocks whose ports are only known at run time: the function receives a
/// `const Reads&` and asks it for the values; a read that was not declared is refused.
inline UsesList<RuntimeSources> UsesAtRunTime(std::vector<const Source*> sources) {
  return {std::tuple<RuntimeSources>{RuntimeSources(std::move(sources))}};
}

namespace internal {

template <class F>
struct MemberFunction : std::false_type {};
template <class R, class C, class... A>
struct MemberFunction<R (C::*)(A...) const> : std::true_type {
  using Class = C;
  using Parameters = std::tuple<std::remove_cvref_t<A>...>;
};
template <class R, class C, class... A>
struct MemberFunction<R (C::*)(A...)> : std::true_type {
  static_assert(sizeof(C) == 0, "A calculation must be const: what changes lives in the context.");
};

/// The function of a calculation, as it was written: a member function of the block, or any callable.
template <class F, class... Values>
decltype(auto) Call(const System* self, const F& function, Values&&... values) {
  if constexpr (MemberFunction<F>::value) {
    using Class = typename MemberFunction<F>::Class;
    return (static_cast<const Class*>(self)->*function)(std::forward<Values>(values)...);
  } else {
    (void)self;
    return function(std::forward<Values>(values)...);
  }
}

/// Exact parameter types make wrong wirings one readable line; Eigen alone would convert and print pages.
template <class Target, class F, class... Arguments>
constexpr bool Fits() {
  if constexpr (MemberFunction<F>::value) {
    using Parameters = typename MemberFunction<F>::Parameters;
    return std::is_same_v<Parameters, std::tuple<std::remove_cvref_t<Arguments>...>> ||
           std::is_same_v<Parameters, std::tuple<std::remove_cvref_t<Arguments>..., Target*>>;
  } else {
    return std::is_invocable_v<F, Arguments...> || std::is_invocable_v<F, Arguments..., Target*>;
  }
}

template <class F, class... Values>
using CallResult =
    decltype(Call(std::declval<const System*>(), std::declval<const F&>(), std::declval<Values>()...));

/// The code that a compiled diagram runs for one calculation. A function either returns the Target or, for
/// large values, takes a `Target*` after its arguments and fills it in place.
template <class Target, class F, class... Handles>
struct Calculation {
  static_assert(Fits<Target, F, typename Handles::Argument...>(),
                "The function's parameters must be exactly the values of Uses(...), in that order.");
  const System* self;
  F function;
  UsesList<Handles...> uses;

  static void Run(const void* closure, std::byte* memory, const Offset* args) {
    const auto& c = *static_cast<const Calculation*>(closure);
    Target* target = std::launder(reinterpret_cast<Target*>(memory + *args++));
    c.Evaluate(target, memory, args, std::index_sequence_for<Handles...>{});
  }

  template <std::size_t... I>
  void Evaluate(Target* target, std::byte* memory, const Offset* args, std::index_sequence<I...>) const {
    (void)memory, (void)args;
    // Braces evaluate from left to right, which the cursor needs.
    const std::tuple<typename Handles::Argument...> values{std::get<I>(uses.handles).Load(memory, args)...};
    if constexpr (InPlace()) {
      Call(self, function, std::get<I>(values)..., target);
    } else {
      using Result = std::remove_cvref_t<CallResult<F, typename Handles::Argument...>>;
      static_assert(std::is_same_v<Result, Target> || (Scalar<Result> && Scalar<Target>),
                    "The function must return exactly the type of the port, state or shared value.");
      *target = Call(self, function, std::get<I>(values)...);
    }
  }

  static constexpr bool InPlace() {
    if constexpr (MemberFunction<F>::value) {
      return std::tuple_size_v<typename MemberFunction<F>::Parameters> == sizeof...(Handles) + 1;
    } else {
      return !std::is_invocable_v<F, typename Handles::Argument...>;
    }
  }
};

}  // namespace internal
}  // namespace tenon
