#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

constexpr const char* kJsonTimestamp = "timestamp";

/// The keys of a signal's numbers: "cart.position".
std::vector<std::string> JsonKeys(const std::string& name, const TypeInfo& type, const void* value,
                                  const Spec& spec);

/// Writes messages of one signal:
///
///     {"timestamp":0.25,"cart":{"position":0.1,"velocity":-0.2}}
///
/// with the elements of the signal as logs name them, a dot being a level. Numbers are the shortest that read
/// back as the same bits; what JSON has no number for is "NaN", "Infinity", "-Infinity". What is no number
/// (text) is left out.
class JsonWriter {
 public:
  /// The message; lies in the writer until the next. Allocates for the first one, and when the value has
  /// changed its size.
  std::span<const char> Write(double time, const std::string& name, const TypeInfo& type, const void* value,
                              const Spec& spec);

 private:
  void Prepare(const std::string& name, const TypeInfo& type, const void* value, const Spec& spec);
  std::vector<std::string> pieces_;  ///< in front of each number, and behind the last
  std::vector<std::size_t> shape_;   ///< of what can change its size
  std::vector<char> text_;
};

}  // namespace tenon::internal
