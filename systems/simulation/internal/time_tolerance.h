#pragma once

#include <cmath>

namespace tenon::internal {

/// Tolerance [s] for a time computed in two ways with one or two additions, which differ by a few units in
/// the last place. A shorter interval cannot be integrated.
inline double Tiny(double time) {
  return 1e-14 * (1 + std::abs(time));
}

}  // namespace tenon::internal
