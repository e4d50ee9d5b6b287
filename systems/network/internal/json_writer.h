#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon::internal {

constexpr const char* kJsonTimestamp = "timestamp";

/// Returns the dotted keys of a signal's numbers: "cart.position".
std::vector<std::string> JsonKeys(const std::string& name, const TypeInfo& type, const void* value,
                                  const Spec& spec);

/// Writes messages of one signal:
///
///     {"timestamp":0.25,"cart":{"position":0.1,"velocity":-0.2}}
///
/// with the elements of the signal named as in logs, one level of objects for each dot. Numbers are written
/// in the shortest form that reads back exactly, and "NaN", "Infinity" and "-Infinity" as texts. Members that
/// are not numbers are omitted.
class JsonWriter {
 public:
  /// Returns the message, which is valid until the next call. Allocates only for the first message and when
  /// the size of the value changes.
  std::span<const char> Write(double time, const std::string& name, const TypeInfo& type, const void* value,
                              const Spec& spec);

 private:
  void Prepare(const std::string& name, const TypeInfo& type, const void* value, const Spec& spec);
  std::vector<std::string> pieces_;  ///< texts before each number and after the last one
  std::vector<std::size_t> shape_;   ///< sizes of matrices and lists of variable size
  std::vector<char> text_;
};

}  // namespace tenon::internal
