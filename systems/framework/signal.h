#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/fields.h>

namespace tenon {

/// A vector signal of N doubles. Identical to Eigen::Matrix<double, N, 1> but never over-aligned, so that a
/// library and a program compiled with different vector instructions agree on its layout.
template <int N>
using Vec = Eigen::Matrix<double, N, 1, (N > 0 && N % 2 == 0) ? Eigen::DontAlign : 0>;

/// The name of a port or a state, and the units and names of its elements.
///
/// `units` and `elements` are comma-separated, one entry per element; a single unit serves all elements.
/// Structs with Fields() bring their own and leave both empty.
struct Spec {
  Spec(const char* name) : name(name) {}  // NOLINT(google-explicit-constructor): a name alone is a spec
  Spec(std::string name, std::string units = "", std::string elements = "")
      : name(std::move(name)), units(std::move(units)), elements(std::move(elements)) {}
  std::string name;
  std::string units;
  std::string elements;
};

/// One scalar of a signal, as logs and state names show it; the name of a scalar signal's element is empty.
struct Element {
  std::string name;
  std::string unit;
};

namespace internal {

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
concept EigenMatrix = std::derived_from<T, Eigen::MatrixBase<T>>;

template <class T>
concept Range = requires(T& t) {
  typename T::value_type;
  t.begin();
  t.end();
  t.size();
}
&&!EigenMatrix<T> && !std::same_as<T, std::string>;

/// A matrix whose numbers lie inside the object.
template <class T>
concept InlineMatrix = EigenMatrix<T> && T::MaxSizeAtCompileTime != Eigen::Dynamic;

/// Copying the bytes copies the value.
template <class T>
inline constexpr bool kBitwise = std::is_trivially_copyable_v<T> || InlineMatrix<T> ||
                                 (HasFields<T> && std::is_trivially_destructible_v<T>);

/// Calls `visit(scalar)` for every double, integer, bool and enumeration inside `value`, in order.
/// What is none of these and does not describe itself has no scalars.
template <class T, class Visit>
void VisitScalars(T& value, Visit&& visit) {
  using Plain = std::remove_const_t<T>;
  if constexpr (Scalar<Plain>) {
    visit(value);
  } else if constexpr (EigenMatrix<Plain>) {
    for (Eigen::Index i = 0; i < value.size(); ++i) VisitScalars(value.data()[i], visit);
  } else if constexpr (HasFields<Plain>) {
    ForEachField(value, [&](const auto&, auto& member) { VisitScalars(member, visit); });
  } else if constexpr (Range<Plain>) {
    for (auto& item : value) VisitScalars(item, visit);
  }
}

/// Names for a vector's elements: from the spec, else x, y, z for three, else their index.
std::string ElementName(const Spec& spec, Eigen::Index row, Eigen::Index col, Eigen::Index rows,
                        Eigen::Index cols);
std::string ElementUnit(const Spec& spec, std::size_t index);

template <class T>
void ListElements(const T& model, const Spec& spec, const std::string& prefix, std::vector<Element>& out) {
  const auto sub = [&](const std::string& name) { return prefix.empty() ? name : prefix + "." + name; };
  if constexpr (Scalar<T>) {
    out.push_back({prefix, spec.units});
  } else if constexpr (EigenMatrix<T>) {
    for (Eigen::Index c = 0; c < model.cols(); ++c)
      for (Eigen::Index r = 0; r < model.rows(); ++r)
        out.push_back({sub(ElementName(spec, r, c, model.rows(), model.cols())),
                       ElementUnit(spec, static_cast<std::size_t>(c * model.rows() + r))});
  } else if constexpr (HasFields<T>) {
    ForEachField(model, [&](const auto& field, const auto& member) {
      ListElements(member, Spec{field.name, field.units}, sub(field.name), out);
    });
  } else if constexpr (Range<T>) {
    std::size_t i = 0;
    for (const auto& item : model) ListElements(item, spec, sub(std::to_string(i++)), out);
  }
}

/// Bytes of a snapshot, appended by Save and taken by Load.
class Archive {
 public:
  void Write(const void* data, std::size_t size);
  void Read(void* data, std::size_t size);  ///< throws RunError past the end
  std::vector<std::byte>& bytes() { return bytes_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }
  bool exhausted() const { return cursor_ == bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t cursor_ = 0;
};

template <class T>
void Save(const T& value, Archive& archive) {
  if constexpr (std::is_trivially_copyable_v<T>) {
    archive.Write(&value, sizeof(T));
  } else if constexpr (HasFields<T>) {
    ForEachField(value, [&](const auto&, const auto& member) { Save(member, archive); });
  } else if constexpr (EigenMatrix<T>) {
    const Eigen::Index shape[2] = {value.rows(), value.cols()};
    archive.Write(shape, sizeof(shape));
    archive.Write(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(value.size()));
  } else if constexpr (Range<T> || std::same_as<T, std::string>) {
    const std::size_t size = value.size();
    archive.Write(&size, sizeof(size));
    for (const auto& item : value) Save(item, archive);
  } else {
    throw Error("its type does not describe itself: give it a static Fields() to make it storable");
  }
}

template <class T>
void Load(T& value, Archive& archive) {
  if constexpr (std::is_trivially_copyable_v<T>) {
    archive.Read(&value, sizeof(T));
  } else if constexpr (HasFields<T>) {
    ForEachField(value, [&](const auto&, auto& member) { Load(member, archive); });
  } else if constexpr (EigenMatrix<T>) {
    Eigen::Index shape[2];
    archive.Read(shape, sizeof(shape));
    value.resize(shape[0], shape[1]);
    archive.Read(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(value.size()));
  } else if constexpr (Range<T> || std::same_as<T, std::string>) {
    std::size_t size = 0;
    archive.Read(&size, sizeof(size));
    if constexpr (requires { value.resize(size); }) value.resize(size);
    for (auto& item : value) Load(item, archive);
  } else {
    throw Error("its type does not describe itself: give it a static Fields() to make it storable");
  }
}

enum class Finiteness { kFinite, kInfinite, kNan };

/// Everything that a context needs to know of the type of a value that it stores.
struct TypeInfo {
  std::size_t size;
  std::size_t alignment;
  bool bitwise;
  void (*copy_construct)(void* at, const void* model);
  void (*destroy)(void* value);
  void (*assign)(void* to, const void* from);
  void (*list_elements)(const void* model, const Spec& spec, std::vector<Element>& out);
  std::size_t (*count)(const void* value);                ///< of its elements
  double* (*to_doubles)(const void* value, double* out);  ///< returns the end of what it wrote
  void (*from_doubles)(void* value, const double* in);
  Finiteness (*finiteness)(const void* value);
  void (*save)(const void* value, Archive& archive);
  void (*load)(void* value, Archive& archive);
};

template <class T>
Finiteness FinitenessOf(const T& value) {
  Finiteness worst = Finiteness::kFinite;
  VisitScalars(value, [&](const auto& scalar) {
    if constexpr (std::is_floating_point_v<std::remove_cvref_t<decltype(scalar)>>) {
      if (scalar != scalar) worst = Finiteness::kNan;
      if (worst == Finiteness::kFinite && scalar - scalar != 0) worst = Finiteness::kInfinite;
    }
  });
  return worst;
}

template <class T>
inline constexpr TypeInfo kTypeInfo{
    .size = sizeof(T),
    .alignment = alignof(T),
    .bitwise = kBitwise<T>,
    .copy_construct = [](void* at, const void* model) { new (at) T(*static_cast<const T*>(model)); },
    .destroy = [](void* value) { static_cast<T*>(value)->~T(); },
    .assign = [](void* to, const void* from) { *static_cast<T*>(to) = *static_cast<const T*>(from); },
    .list_elements =
        [](const void* model, const Spec& spec, std::vector<Element>& out) {
          ListElements(*static_cast<const T*>(model), spec, "", out);
        },
    .count =
        [](const void* value) {
          std::size_t count = 0;
          VisitScalars(*static_cast<const T*>(value), [&](const auto&) { ++count; });
          return count;
        },
    .to_doubles =
        [](const void* value, double* out) {
          VisitScalars(*static_cast<const T*>(value),
                       [&](const auto& scalar) { *out++ = static_cast<double>(scalar); });
          return out;
        },
    .from_doubles =
        [](void* value, const double* in) {
          VisitScalars(*static_cast<T*>(value), [&](auto& scalar) {
            scalar = static_cast<std::remove_cvref_t<decltype(scalar)>>(*in++);
          });
        },
    .finiteness = [](const void* value) { return FinitenessOf(*static_cast<const T*>(value)); },
    .save = [](const void* value, Archive& archive) { Save(*static_cast<const T*>(value), archive); },
    .load = [](void* value, Archive& archive) { Load(*static_cast<T*>(value), archive); },
};

/// A value of type T with every number in it zero.
template <class T>
T Zeroed() {
  T value{};
  VisitScalars(value, [](auto& scalar) { scalar = std::remove_cvref_t<decltype(scalar)>{}; });
  return value;
}

}  // namespace internal
}  // namespace tenon
