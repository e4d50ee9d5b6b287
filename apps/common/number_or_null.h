#pragma once

#include <nlohmann/json.hpp>

#include <optional>

namespace tenon::apps {

/// Converts a number to JSON, null if it is empty.
inline nlohmann::ordered_json NumberOrNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace tenon::apps
