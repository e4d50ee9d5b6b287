#pragma once

#include <tenon/systems/framework/types/range.h>
#include <tenon/systems/framework/types/scale.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <vector>

namespace tenon {

class Rate;

namespace internal {

struct TypeInfo;
template <class T>
const TypeInfo& TypeInfoOf();

/// Offset of the member in Struct [bytes].
template <class Struct, class Member>
std::size_t OffsetOf(Member Struct::*member) {
  const auto* somewhere = reinterpret_cast<const Struct*>(alignof(Struct) * 1024);
  return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(&(somewhere->*member)) -
                                  reinterpret_cast<const std::byte*>(somewhere));
}

/// Number of initialisers that a member takes in the braces of its struct: for a C array the number of its
/// items.
template <class Member>
inline constexpr std::size_t kInitializers = sizeof(Member) / sizeof(std::remove_all_extents_t<Member>);

/// True for a pointer to data that no run changes.
template <class Member>
inline constexpr bool kPointsToConstant = false;
template <class T>
inline constexpr bool kPointsToConstant<const T*> = true;
template <class T>
inline constexpr bool kPointsToConstant<std::shared_ptr<const T>> = true;

}  // namespace internal

/// Specialise it to tell snapshots how they contain a type that cannot have Fields(), such as the state of C
/// code or of generated code, by a pair of functions:
///
///     template <>
///     struct tenon::SnapshotOf<Engine> {
///       static std::vector<std::byte> Save(const Engine& engine);
///       static void Load(std::span<const std::byte> bytes, Engine& engine);  // throws if they are invalid
///     };
///
/// A copy of the value must be independent of the original, because Clone copies it. See BytesOf.
template <class T>
struct SnapshotOf;

/// The pair of functions for a plain struct without pointers, whose bytes are its state:
/// `template <> struct tenon::SnapshotOf<model_DW> : tenon::BytesOf<model_DW> {};`
template <class T>
struct BytesOf {
  static_assert(std::is_trivially_copyable_v<T>, "BytesOf: the bytes of this type are not its state.");
  static std::vector<std::byte> Save(const T& value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    return {bytes, bytes + sizeof(T)};
  }
  static void Load(std::span<const std::byte> bytes, T& value) {
    if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
  }
};

/// One member of a struct that describes itself: its name, its units, the names of its elements, and its
/// offset.
///
/// A struct lists its members once; logs, state names, snapshots and YAML files are derived from that list:
///
///     struct SpringState {
///       double force = 0;
///       Vec<3> p_W;
///       static FieldList Fields() {
///         return {{"force", &SpringState::force, "N"}, {"p_W", &SpringState::p_W, "m"}};
///       }
///     };
///
/// A struct of parameters has the unit in the key (`mass_kg`), marks members without a default as Required,
/// and gives the range of a member beside its unit. Files, blocks and Parameters refuse values outside:
///
///     Field("mass_kg", &Cart::mass).Positive(),  Field("share", &Cart::share).AtLeast(0).Below(1)
///
/// A member of a member is listed by both: Field("noise_N", &Sensor::error, &SensorError::absolute). A rate
/// is given in Hz.
///
/// Every member must be listed, as `Undescribed` if logs and snapshots omit it on purpose: the first use of a
/// struct whose list lacks a member throws BuildError. The members of an aggregate are counted. In a class
/// with constructors, private members or bases, the listed members must fill the object except for padding; a
/// forgotten member that fits into padding is not detected there.
class Field {
 public:
  template <class Struct, class Member>
  Field(const char* label, Member Struct::*member, const char* unit = "", const char* parts = "")
      : name(label),
        units(unit),
        elements(parts),
        offset(internal::OffsetOf(member)),
        size(sizeof(Member)),
        whole(offset),
        whole_size(size),
        initializers(internal::kInitializers<Member>),
        type(&internal::TypeInfoOf<Member>),
        owner(&typeid(Struct)) {
    if constexpr (std::is_same_v<Member, Rate>) range.Above(0).AtMost(kFastestRate);
  }
  /// A member of a member of the struct.
  template <class Struct, class Member, class Part, class Inner>
  requires std::is_base_of_v<Part, Member> Field(const char* label, Member Struct::*member,
                                                 Inner Part::*inner)
      : Field(label, static_cast<Inner Member::*>(inner)) {
    MoveInto(member);
    owner = &typeid(Struct);
  }
  /// A member without description: see `Undescribed`.
  template <class Struct, class Member>
  explicit Field(Member Struct::*member)
      : offset(internal::OffsetOf(member)),
        size(sizeof(Member)),
        whole(offset),
        whole_size(size),
        initializers(internal::kInitializers<Member>),
        described(false),
        constant(internal::kPointsToConstant<Member>) {}

  /// The range of the member's numbers, see Range.
  Field& In(const Range& given) { return range = given, *this; }
  Field& Finite() { return range.Finite(), *this; }
  Field& Positive() { return range.Positive(), *this; }
  Field& OrInfinite() { return range.OrInfinite(), *this; }
  Field& Above(double end) { return range.Above(end), *this; }
  Field& AtLeast(double end) { return range.AtLeast(end), *this; }
  Field& Below(double end) { return range.Below(end), *this; }
  Field& AtMost(double end) { return range.AtMost(end), *this; }
  Field& Between(double first, double last) { return range.Between(first, last), *this; }
  Field& Because(const char* remedy) { return range.Because(remedy), *this; }

  /// A vector for which a file may give one number for all elements.
  Field& Uniform() { return uniform = true, *this; }
  /// A file for systems of all sizes gives this number under another key, in units of the system's scale:
  ///
  ///     .Scaled("stiffness_mg_per_l", [](double k, const Scale& s) { return k * (s.Weight() / s.length); })
  ///
  /// Such a file must give it, unless the default is 0, which holds for all sizes.
  Field& Scaled(const char* key, double (*convert)(double value, const Scale& scale)) {
    return scaled_name = key, scaled = convert, *this;
  }
  /// A number that is the same for all sizes, but which a file for all sizes must give like scaled ones.
  Field& Scaled() {
    return Scaled(name, [](double value, const Scale&) { return value; });
  }

  /// Makes this field of a struct one of the struct that contains it as `member`.
  template <class Struct, class Member>
  void MoveInto(Member Struct::*member) {
    whole = internal::OffsetOf(member);
    whole_size = sizeof(Member);
    offset += whole;
    initializers = internal::kInitializers<Member>;
  }

  static constexpr double kFastestRate = 1e5;  ///< highest rate in a file [Hz]
  const char* name = "";
  const char* units = "";
  const char* elements = "";  ///< names of a vector's elements or an array's items, as in a Spec
  std::size_t offset;         ///< place of the member in the struct [bytes]
  std::size_t size;           ///< size of the member [bytes]
  std::size_t whole;          ///< place of the struct's member that is, or contains, this one [bytes]
  std::size_t whole_size;     ///< size of that member [bytes]
  std::size_t initializers;   ///< number of initialisers of that member in the braces of its struct
  const internal::TypeInfo& (*type)() = nullptr;  ///< type of the member; null if the list tells no name
  const std::type_info* owner = nullptr;          ///< struct that declares the member
  bool required = false;
  bool described = true;  ///< whether logs, files and snapshots contain the member
  bool constant = false;  ///< a member without description that points to data that no run changes
  bool uniform = false;   ///< one number may stand for all elements of the vector
  const char* scaled_name = "";
  double (*scaled)(double value, const Scale& scale) = nullptr;  ///< null if it holds for one size only
  Range range = {};
};

/// The members of a struct that logs, snapshots and files contain, in order.
using FieldList = std::vector<Field>;

/// The fields of a base and those of the struct that is derived from it.
inline FieldList operator+(FieldList fields, const FieldList& more) {
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

/// A field without a default: a file that omits it is rejected.
template <class Struct, class Member>
Field Required(const char* name, Member Struct::*member) {
  Field field(name, member);
  field.required = true;
  return field;
}

/// A member that logs, files and snapshots omit: a pointer to constant data, or a value that does not change.
/// Clone copies it; Restore leaves it unchanged. A DiscreteState or a Scratch may have only pointers to
/// constant data as such members, or it cannot be saved: Restore would keep their values of the future.
template <class Struct, class Member>
Field Undescribed(Member Struct::*member) {
  return Field(member);
}
/// Such a member of a block's parameters that has a range: Undescribed("gravity", &P::gravity).Positive().
template <class Struct, class Member>
Field Undescribed(const char* name, Member Struct::*member) {
  Field field(name, member);
  field.described = false;
  return field;
}

/// Adds the fields of a member, whose keys stand beside those of the struct that contains it.
template <class Struct, class Member>
void AddInline(FieldList& fields, Member Struct::*member) {
  for (Field field : Member::Fields()) {
    field.MoveInto(member);
    fields.push_back(field);
  }
}

/// Structs with a static `FieldList Fields()`.
template <class T>
concept HasFields = requires {
  { std::remove_cvref_t<T>::Fields() } -> std::same_as<FieldList>;
};

namespace internal {

template <class T>
const FieldList& FieldsOf() {
  static const FieldList kFields = T::Fields();
  return kFields;
}

/// A value with a name and a range.
struct Ranged {
  const char* name;
  const char* units;
  const Range* range;
  const TypeInfo* type;
};

/// Throws ParameterError if a number in the value is out of range, also in structs inside it. The message
/// begins with `path` and the name.
void CheckRange(const Ranged& member, const void* value, const char* path = "");
/// Does the same for one member, and for all members, of a struct.
void CheckRange(const Field& field, const void* object, const char* path = "");
void CheckRanges(const FieldList& fields, const void* object, const char* path = "");
/// Returns the range of each number in the value.
std::vector<Range> ListRanges(const Ranged& member, const void* value);

}  // namespace internal

/// Throws ParameterError if a member, or a member of a struct inside, is out of range. The message begins
/// with `path` and the names of the members.
template <HasFields T>
void CheckRanges(const T& value, const char* path = "") {
  internal::CheckRanges(internal::FieldsOf<T>(), &value, path);
}

/// An enumerator and its name in files and on pages.
template <class E>
struct Named {
  E value;
  const char* name;
};
template <class E>
Named(E, const char*) -> Named<E>;

namespace internal {

/// The text of an enumerator in the program, `tenon::Gait::kTrot`, or of another value, `(tenon::Gait)7`.
template <auto value>
consteval std::string_view ProgramText() {
  const std::string_view text = __PRETTY_FUNCTION__;  // "… [with auto value = TEXT; …]", "… [value = TEXT]"
  const std::size_t begin = text.find("value = ") + 8;
  return text.substr(begin, text.find_first_of(";]", begin) - begin);
}

/// The name of an enumerator: that in the program without its k, in lower case; empty for another value.
template <auto value>
consteval std::array<char, 64> MakeEnumeratorName() {
  std::string_view text = ProgramText<value>();
  text.remove_prefix(text.rfind(':') + 1);
  if (text.find(')') != text.npos) return {};
  const auto upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.size() > 1 && text[0] == 'k' && upper(text[1])) text.remove_prefix(1);
  std::array<char, 64> name{};
  std::size_t end = 0;
  char before = 0;
  for (const char c : text) {
    if (end > 0 && ((upper(c) && !upper(before)) || (digit(c) && !digit(before)))) name[end++] = '_';
    name[end++] = static_cast<char>(upper(c) ? c - 'A' + 'a' : c);
    before = c;
  }
  return name;
}
template <auto value>
inline constexpr std::array<char, 64> kEnumeratorName = MakeEnumeratorName<value>();

/// Number of enumerators with the values 0, 1, 2, …
template <class E, int n = 0>
consteval int CountEnumerators() {
  if constexpr (static_cast<int>(static_cast<E>(n)) != n || kEnumeratorName<static_cast<E>(n)>[0] == 0)
    return n;
  else
    return CountEnumerators<E, n + 1>();
}

template <class E>
concept ScopedEnum = std::is_enum_v<E> && !std::is_convertible_v<E, std::underlying_type_t<E>>;

template <class E, int... n>
constexpr auto NamesOf(std::integer_sequence<int, n...>) {
  return std::array{Named{static_cast<E>(n), kEnumeratorName<static_cast<E>(n)>.data()}...};
}

}  // namespace internal

/// The enumerators and names of an enum class whose values are 0, 1, 2, …: `kRungeKutta4` has the name
/// runge_kutta_4. For other values or names, define a function beside the enum:
///
///     constexpr auto EnumNames(SwitchMode) {
///       return std::array{Named{SwitchMode::kOff, "0"}, Named{SwitchMode::kOn, "1"}};
///     }
template <internal::ScopedEnum E>
requires(internal::CountEnumerators<E>() > 0) constexpr auto EnumNames(E) {
  return internal::NamesOf<E>(std::make_integer_sequence<int, internal::CountEnumerators<E>()>());
}

/// An enum whose enumerators have names.
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
