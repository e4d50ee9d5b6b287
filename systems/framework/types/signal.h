#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/internal/type_info.h>

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <utility>

namespace tenon {

/// A vector signal of N doubles. Identical to Eigen::Matrix<double, N, 1> but never over-aligned, so that a
/// library and a program compiled with different vector instructions agree on its layout.
template <int N>
using Vec = Eigen::Matrix<double, N, 1, (N > 0 && N % 2 == 0) ? Eigen::DontAlign : 0>;

/// The name of a port or a state, and the units and names of its elements.
///
/// `units` and `elements` are comma-separated, one entry per element; a single unit serves all elements. Of
/// an array, `elements` names the items, and `units` are those of each item. Structs with Fields() bring
/// their own and leave both empty.
struct Spec {
  Spec(const char* name);  // NOLINT(google-explicit-constructor): a name alone is a spec
  Spec(std::string name, std::string units = "", std::string elements = "");
  std::string name;
  std::string units;
  std::string elements;
};

/// One scalar of a signal, as logs and state names show it; the name of a scalar signal's element is empty.
struct Element {
  std::string name;
  std::string unit;
  bool is_real = true;  ///< else a bool, an integer or an enumeration, which changes by jumps only
};

namespace internal {

/// How many entries a comma-separated list has; 0 if it is empty.
std::size_t ListLength(const std::string& list);
/// `spec` with what it leaves empty taken from another.
Spec Completed(Spec spec, const Spec& other);
/// The unit of the `index`-th element.
std::string ElementUnit(const Spec& spec, std::size_t index);

/// Names and units of a value's numbers.
std::vector<Element> ListElements(const TypeInfo& type, const void* value, const Spec& spec);
std::size_t CountScalars(const TypeInfo& type, const void* value);
/// Writes all numbers of a value; returns the end of what it wrote.
double* ToDoubles(const TypeInfo& type, const void* value, double* out);
/// A number that an element of a value cannot hold: which element, and what it can be; whose, says who
/// catches it.
class NumberError : public ParameterError {
 public:
  using ParameterError::ParameterError;
};
/// Reads all numbers of a value. Throws NumberError at the first that is no value of its element, a fraction
/// for an integer, say, unless it is there already; those before it are written.
void FromDoubles(const TypeInfo& type, void* value, const double* in);

/// False for an enumeration with names of which none has this value.
bool IsNamed(const TypeInfo& type, const void* value);
/// "0 (stance), 1 (swing)"
std::string NamedValues(const TypeInfo& type);

enum class Finiteness { kFinite, kInfinite, kNan };
Finiteness FinitenessOf(const TypeInfo& type, const void* value);

template <class T>
bool IsFinite(const T& value) {
  return FinitenessOf(TypeInfoOf<T>(), &value) == Finiteness::kFinite;
}

/// Bytes of a snapshot, appended by Save and taken by Load.
class Archive {
 public:
  void Write(const void* data, std::size_t size);
  void Read(void* data, std::size_t size);  ///< throws RunError past the end
  void Demand(std::size_t size) const;      ///< that as many bytes are left
  std::vector<std::byte>& bytes() { return bytes_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }
  bool exhausted() const { return cursor_ == bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t cursor_ = 0;
};

/// Throw Error if the value, or a part of it, does not describe itself.
void Save(const TypeInfo& type, const void* value, Archive& archive);
void Load(const TypeInfo& type, void* value, Archive& archive);
template <Scalar T>
void Save(const T& value, Archive& archive) {
  archive.Write(&value, sizeof(T));
}
template <Scalar T>
void Load(T& value, Archive& archive) {
  archive.Read(&value, sizeof(T));
}
void Load(bool& value, Archive& archive);  ///< throws RunError for a byte that is neither 0 nor 1

void SetZero(const TypeInfo& type, void* value);

/// A value of type T with every number in it zero.
template <class T>
T Zeroed() {
  T value{};
  SetZero(TypeInfoOf<T>(), &value);
  return value;
}

}  // namespace internal
}  // namespace tenon
