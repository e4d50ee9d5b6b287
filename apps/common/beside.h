#pragma once

#include <string>
#include <utility>

namespace tenon::apps {

/// A value and its limit as texts, with as many digits, `digits` or more, as it takes to tell them apart.
std::pair<std::string, std::string> Beside(double value, double limit, int digits = 3);

}  // namespace tenon::apps
