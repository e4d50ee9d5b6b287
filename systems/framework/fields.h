#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace tenon {

namespace internal {

struct TypeInfo;
template <class T>
const TypeInfo& TypeInfoOf();

/// How far inside a Struct the member lies [bytes].
template <class Struct, class Member>
std::size_t OffsetOf(Member Struct::*member) {
  const auto* somewhere = reinterpret_cast<const Struct*>(alignof(Struct) * 1024);
  return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(&(somewhere->*member)) -
                                  reinterpret_cast<const std::byte*>(somewhere));
}

}  // namespace internal

/// One member of a struct that describes itself: its name, its units and the names of its elements if it has
/// any, and where it is.
///
/// A struct says once what it holds; logs, state names, snapshots and YAML files are made from that:
///
///     struct SpringState {
///       double force = 0;
///       Vec<3> p_W;
///       static FieldList Fields() {
///         return {{"force", &SpringState::force, "N"}, {"p_W", &SpringState::p_W, "m"}};
///       }
///     };
///
/// A struct of parameters carries the unit in the key (`mass_kg`) and marks what has no default as Required.
class Field {
 public:
  template <class Struct, class Member>
  Field(const char* name, Member Struct::*member, const char* units = "", const char* elements = "")
      : name(name),
        units(units),
        elements(elements),
        offset(internal::OffsetOf(member)),
        type(&internal::TypeInfoOf<Member>) {}

  const char* name;
  const char* units;
  const char* elements;                 ///< names of a vector's elements or of an array's items, as in a Spec
  std::size_t offset;                   ///< of the member in the struct [bytes]
  const internal::TypeInfo& (*type)();  ///< of the member
  bool required = false;
};

/// All that logs, snapshots and files hold of a struct, in order.
using FieldList = std::vector<Field>;

/// A field without a default: a file that leaves it out is refused.
template <class Struct, class Member>
Field Required(const char* name, Member Struct::*member) {
  Field field(name, member);
  field.required = true;
  return field;
}

/// True for structs with a static `FieldList Fields()`.
template <class T>
concept HasFields = requires {
  { std::remove_cvref_t<T>::Fields() } -> std::same_as<FieldList>;
};

/// An enumerator and what files and pages call it.
template <class E>
struct Named {
  E value;
  const char* name;
};
template <class E>
Named(E, const char*) -> Named<E>;

/// An enum that is known by names. Beside the enum stands, say,
///
///     constexpr auto EnumNames(SwitchMode) {
///       return std::array{Named{SwitchMode::kOff, "off"}, Named{SwitchMode::kOn, "on"}};
///     }
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E e) {
  EnumNames(e);
};

/// The name of an enumerator; "?" for a value that has none.
template <NamedEnum E>
constexpr const char* EnumName(E value) {
  for (const auto& [e, name] : EnumNames(value)) {
    if (e == value) return name;
  }
  return "?";
}

}  // namespace tenon
