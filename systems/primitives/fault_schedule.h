#pragma once

#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/framework/types/fields.h>

#include <cmath>
#include <limits>
#include <string>

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
    return {{"start", &FaultSchedule::start, "s"}, {"duration", &FaultSchedule::duration, "s"}};
  }
  /// Throws ParameterError if start is not finite or duration is negative.
  void Validate() const {
    Demand(std::isfinite(start),
           "schedule.start = " + std::to_string(start) + " must be finite: give seconds");
    Demand(duration >= 0, "schedule.duration = " + std::to_string(duration) +
                              " must not be negative: give seconds, infinity for a permanent fault");
  }
};

}  // namespace tenon
