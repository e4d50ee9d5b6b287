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

/// How many initialisers a member takes in the braces of its struct: a C array as many as it has items.
template <class Member>
inline constexpr std::size_t kInitializers = sizeof(Member) / sizeof(std::remove_all_extents_t<Member>);

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
///
/// Every member must be listed, as Undescribed if it is meant to stay out of logs and snapshots: the first
/// use of a struct whose list lacks a member throws BuildError. The members of an aggregate are counted. In a
/// class with constructors, private members or bases, the listed members must fill the object except for
/// padding; a forgotten member that is small enough to lie in padding is not noticed there.
class Field {
 public:
  template <class Struct, class Member>
  Field(const char* name, Member Struct::*member, const char* units = "", const char* elements = "")
      : Field(member) {
    this->name = name;
    this->units = units;
    this->elements = elements;
    type = &internal::TypeInfoOf<Member>;
  }
  /// A member that is not described: see Undescribed.
  template <class Struct, class Member>
  explicit Field(Member Struct::*member)
      : offset(internal::OffsetOf(member)),
        size(sizeof(Member)),
        initializers(internal::kInitializers<Member>) {}

  const char* name = "";
  const char* units = "";
  const char* elements = "";  ///< names of a vector's elements or of an array's items, as in a Spec
  std::size_t offset;         ///< of the member in the struct [bytes]
  std::size_t size;           ///< of the member [bytes]
  std::size_t initializers;   ///< of the member, in the braces of its struct
  const internal::TypeInfo& (*type)() = nullptr;  ///< of the member; null if it is not described
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

/// A member that logs, files and snapshots leave out: a pointer to shared data, say, or what is computed from
/// the others. A clone of a context has it; a context that is restored keeps its own.
template <class Struct, class Member>
Field Undescribed(Member Struct::*member) {
  return Field(member);
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
