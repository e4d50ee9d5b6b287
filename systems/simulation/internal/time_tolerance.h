#pragma once

#include <algorithm>
#include <cmath>

namespace tenon::internal {

// Tolerances within which two times count as equal, from the smallest to the largest. Each covers the
// rounding of a different computation.

/// Tolerance [s] for a time computed in two ways with one or two additions, which differ by a few units in
/// the last place. A shorter interval cannot be integrated.
inline double Tiny(double time) {
  return 1e-14 * (1 + std::abs(time));
}

/// Tolerance [s] between times that users compute as sums of periods and tick times, which are quotients of
/// integers: a tick this close to the end of an advance belongs to it. The upper limit keeps it below any
/// sensible period late in a long run.
inline double TickRounding(double time) {
  return std::min(1e-10 * (1 + std::abs(time)), 1e-7);
}

}  // namespace tenon::internal
