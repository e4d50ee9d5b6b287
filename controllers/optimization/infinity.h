#pragma once

#include <limits>

namespace tenon {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();  ///< a bound that never binds

}  // namespace tenon
