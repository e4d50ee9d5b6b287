#pragma once

#include <tuple>
#include <type_traits>
#include <utility>

namespace tenon {

/// One member of a struct that describes itself: its name, its units if it has any, and where it is.
///
/// A struct says once what it holds; logs, state names, snapshots and YAML files are made from that:
///
///     struct CableState {
///       double tension = 0;
///       Vec<3> p_W;
///       static constexpr auto Fields() {
///         return std::tuple{Field{"tension", &CableState::tension, "N"}, Field{"p_W", &CableState::p_W,
///         "m"}};
///       }
///     };
///
/// A struct of parameters carries the unit in the key (`mass_kg`) and marks what has no default as Required.
template <class Struct, class Member>
struct Field {
  const char* name;
  Member Struct::*member;
  const char* units = "";
  bool required = false;
};

template <class Struct, class Member>
Field(const char*, Member Struct::*) -> Field<Struct, Member>;
template <class Struct, class Member>
Field(const char*, Member Struct::*, const char*) -> Field<Struct, Member>;

/// A field without a default: a file that leaves it out is refused.
template <class Struct, class Member>
constexpr Field<Struct, Member> Required(const char* name, Member Struct::*member) {
  return {name, member, "", true};
}

/// True for structs with a static `Fields()`.
template <class T>
concept HasFields = requires {
  std::remove_cvref_t<T>::Fields();
};

/// Calls `visit(field, value.*field.member)` for every field of `value` in order.
template <HasFields T, class Visit>
constexpr void ForEachField(T& value, Visit&& visit) {
  std::apply([&](const auto&... field) { (visit(field, value.*field.member), ...); },
             std::remove_cvref_t<T>::Fields());
}

}  // namespace tenon
