#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <unordered_map>
#include <variant>

namespace tenon::internal {

constexpr const char* kJsonTimestamp = "timestamp";

/// Returns the dotted keys of a signal's numbers: "cart.position".
std::vector<std::string> JsonKeys(const std::string& name, const TypeInfo& type, const void* value,
                                  const Spec& spec);

/// Writes messages of one signal, see UdpPublisher.
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

/// A number in JSON.
using JsonNumber = std::variant<double, std::int64_t, std::uint64_t, bool>;

/// Reads the messages of JsonWriter, also with flat names ("cart.position"), into values of the size of a
/// model.
class JsonReader {
 public:
  JsonReader(std::string name, const TypeInfo& type, const void* model, const Spec& spec);
  /// Reads a message. Returns an empty text, or the reason of a refusal, which leaves `value` unchanged:
  /// invalid JSON, an unknown or missing key, or a number that its element cannot represent.
  std::string Read(std::span<const char> message, double* timestamp, void* value);

 private:
  class Handler;

  const TypeInfo& type_;
  std::vector<std::string> names_;  ///< names of the elements, followed by "timestamp"
  std::unordered_map<std::string, std::size_t> places_;
  std::vector<ScalarKind> kinds_;
  std::vector<const TypeInfo*> enumerations_;  ///< null for other elements
  std::vector<JsonNumber> numbers_;            ///< numbers of the current message
  std::vector<bool> given_;
};

}  // namespace tenon::internal
