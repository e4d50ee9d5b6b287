#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

namespace tenon::internal {

/// A number as JSON has it.
using JsonNumber = std::variant<double, std::int64_t, std::uint64_t, bool>;

/// Reads such messages, flat names ("cart.position") as well, into values of the size of a model.
class JsonReader {
 public:
  JsonReader(std::string name, const TypeInfo& type, const void* model, const Spec& spec);
  /// Returns why the message is refused, with `value` as it was; empty if it is not: it is no such object, or
  /// has a key too many or too few, or a number that its element cannot hold.
  std::string Read(std::span<const char> message, double* timestamp, void* value);

 private:
  class Handler;

  const TypeInfo& type_;
  std::vector<std::string> names_;  ///< of the elements, "timestamp" behind them
  std::unordered_map<std::string, std::size_t> places_;
  std::vector<ScalarKind> kinds_;
  std::vector<const TypeInfo*> enumerations_;  ///< null for other elements
  std::vector<JsonNumber> numbers_;            ///< of the present message
  std::vector<bool> given_;
};

}  // namespace tenon::internal
