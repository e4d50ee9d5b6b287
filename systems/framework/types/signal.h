#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/internal/type_info.h>

namespace tenon {

/// A vector signal of N doubles. Like Eigen::Matrix<double, N, 1>, but never over-aligned, so that a library
/// and a program compiled for different vector instructions agree on its layout.
template <int N>
using Vec = Eigen::Matrix<double, N, 1, (N > 0 && N % 2 == 0) ? Eigen::DontAlign : 0>;

/// The name of a port or a state, and the units and names of its elements.
///
/// `units` and `elements` are comma-separated, one entry per element; a single unit applies to all elements.
/// For an array, `elements` names the items, and `units` are those of each item. Structs with Fields() bring
/// their own, so that both stay empty.
struct Spec {
  Spec(const char* name);  // NOLINT(google-explicit-constructor): a name alone is a spec
  Spec(std::string name, std::string units = "", std::string elements = "");
  std::string name;
  std::string units;
  std::string elements;
};

/// One scalar of a signal, as shown in logs and state names. The name is empty if the signal is a scalar.
struct Element {
  std::string name;
  std::string unit;
  bool is_real = true;  ///< false for a bool, an integer or an enumeration, which change only by jumps
  /// Its name in a log that has the signal under the name `signal`: "cart.state.velocity".
  std::string PathIn(const std::string& signal) const { return name.empty() ? signal : signal + "." + name; }
};

namespace internal {

/// Number of entries of a comma-separated list; 0 if it is empty.
std::size_t ListLength(const std::string& list);
/// `spec` with empty fields taken from `other`.
Spec Completed(Spec spec, const Spec& other);
/// The unit of the `index`-th element.
std::string ElementUnit(const Spec& spec, std::size_t index);

/// Names and units of a value's numbers.
std::vector<Element> ListElements(const TypeInfo& type, const void* value, const Spec& spec);
std::size_t CountScalars(const TypeInfo& type, const void* value);
/// Writes all numbers of a value; returns the end of what it wrote.
double* ToDoubles(const TypeInfo& type, const void* value, double* out);
/// Returns all numbers of a value.
std::vector<double> DoublesOf(const TypeInfo& type, const void* value);
/// An element of a value cannot hold a number. The text names the element and its range; the catcher adds the
/// source.
class NumberError : public ParameterError {
 public:
  using ParameterError::ParameterError;
};
/// Reads all numbers of a value. Throws NumberError at the first number that its element cannot hold (a
/// fraction for an integer, say), unless the element already has that value; the numbers before it are
/// written.
void FromDoubles(const TypeInfo& type, void* value, const double* in);

/// False for an enumeration with names if none of them has this value.
bool IsNamed(const TypeInfo& type, const void* value);
/// The names and values of an enumeration, as "0 (stance), 1 (swing)".
std::string NamedValues(const TypeInfo& type);

enum class Finiteness { kFinite, kInfinite, kNan };
Finiteness FinitenessOf(const TypeInfo& type, const void* value);

template <class T>
bool IsFinite(const T& value) {
  return FinitenessOf(TypeInfoOf<T>(), &value) == Finiteness::kFinite;
}

/// Bytes of a snapshot: Save appends them and Load consumes them.
class Archive {
 public:
  void Write(const void* data, std::size_t size);
  void Read(void* data, std::size_t size);  ///< throws RunError past the end
  void Demand(std::size_t size) const;      ///< throws RunError if fewer bytes are left
  std::vector<std::byte>& bytes() { return bytes_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }
  bool exhausted() const { return cursor_ == bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t cursor_ = 0;
};

/// Throws Error if the value, or a part of it, does not describe itself or, if it must be `whole`, has
/// Undescribed members that may change.
void Save(const TypeInfo& type, const void* value, Archive& archive, bool whole = false);
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

/// True if all numbers are finite.
template <class T>
bool AllFinite(const T* numbers, std::size_t count) {
  // The sum of 0 x is 0 if and only if every x is finite.
  double zero = 0;
  for (std::size_t i = 0; i < count; ++i) zero += 0 * static_cast<double>(numbers[i]);
  return zero == 0;
}

/// A value of type T with every number in it zero.
template <class T>
T Zeroed() {
  T value{};
  SetZero(TypeInfoOf<T>(), &value);
  return value;
}

}  // namespace internal
}  // namespace tenon
