#pragma once

#include <string>

namespace tenon::internal {

/// Divides each of the comma-separated units by a unit of time: "m, rad" per "s" is "m/s, rad/s".
inline std::string Per(const std::string& units, const std::string& time) {
  std::string quotients;
  for (const char c : units + ",") {
    if (c == ',' && !quotients.empty()) quotients += "/" + time;
    quotients += c;
  }
  quotients.pop_back();
  return quotients;
}

}  // namespace tenon::internal
