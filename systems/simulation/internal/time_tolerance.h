#pragma once

#include <algorithm>
#include <cmath>

namespace tenon::internal {

// By how much two times may differ and still be the same, from the smallest difference to the largest. Each
// absorbs the rounding of another kind of arithmetic.

/// One time that is computed in two ways, with an addition or two, differs by a few units in the last place:
/// an interval within this tolerance [s] has no inside that could be integrated.
inline double Tiny(double time) {
  return 1e-14 * (1 + std::abs(time));
}

/// The rounding of many steps adds up: a step that ends this close [s] to the end of its interval ends there.
inline double StepRounding(double time) {
  return 1e-12 * (1 + std::abs(time));
}

/// Times that users compute as sums of periods round differently than the times of ticks, which are divided
/// from integers: a tick within this tolerance [s] of the end of an advance belongs to the advance. It is
/// capped, so that late in a long run it stays below any sensible period.
inline double TickRounding(double time) {
  return std::min(1e-10 * (1 + std::abs(time)), 1e-7);
}

/// Events that follow one another faster [s] belong to one instant: chatter advances by some 1e-8 s from one
/// event to the next, and would otherwise be a motion without end.
inline constexpr double kInstant = 1e-7;

}  // namespace tenon::internal
