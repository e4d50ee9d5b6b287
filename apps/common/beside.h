#pragma once

#include <string>
#include <utility>

namespace tenon::apps {

/// Formats a value and its limit with enough digits, at least `digits`, to distinguish them.
std::pair<std::string, std::string> Beside(double value, double limit, int digits = 3);

}  // namespace tenon::apps
