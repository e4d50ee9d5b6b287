#pragma once

#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon::internal {

/// The derivative of a sampled signal, with a first-order low-pass filter, by backward differences:
///
///     d[n] = (T d[n - 1] + u[n] - u[n - 1]) / (T + h),   d[0] = 0
///
/// Stable for every T >= 0; T = 0 gives the plain difference (Åström and Hägglund, "PID Controllers: Theory,
/// Design, and Tuning", ISA 1995, chapter 3).
template <DoubleOrMatrix T>
struct FilteredDifference {
  T u = Filled<T>(0), d = Filled<T>(0);
  bool started = false;

  FilteredDifference Next(const T& next_u, double time_constant, double period) const {
    if (!started) return {next_u, d, true};
    return {next_u, (1 / (time_constant + period)) * (time_constant * d + (next_u - u)), true};
  }
  static FieldList Fields() {
    return {{"u", &FilteredDifference::u},
            {"d", &FilteredDifference::d},
            {"started", &FilteredDifference::started}};
  }
};

}  // namespace tenon::internal
