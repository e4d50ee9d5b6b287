#pragma once

#include <tenon/systems/block.h>

namespace tenon {

/// Time interval in which a fault acts: start <= t < start + duration, both rounded up to the ticks of its
/// block.
struct FaultSchedule {
  double start = 0;                                           ///< [s]
  double duration = std::numeric_limits<double>::infinity();  ///< [s]; infinite: until the end of the run

  bool Acts(double time, const Rate& rate) const {
    // Ticks are exact multiples of the period, but the sum of two decimal numbers is not.
    const double since = time - start + 1e-6 * rate.period();
    return since >= 0 && since < duration;
  }
  static FieldList Fields() {
    return {Field("start", &FaultSchedule::start, "s").Finite(),
            Field("duration", &FaultSchedule::duration, "s").AtLeast(0).OrInfinite()};
  }
};

}  // namespace tenon
