#pragma once

#include <cstdint>

namespace tenon::internal {

/// An exact fraction with a positive denominator.
struct Rational {
  std::int64_t numerator;
  std::int64_t denominator;
  friend bool operator==(const Rational&, const Rational&) = default;
};

/// The simplest fraction within a relative error of 1e-12 of `value` >= 0. Throws ParameterError that
/// contains `what` if its denominator exceeds 10^6.
Rational ToRational(double value, const char* what, const char* unit = "s");

}  // namespace tenon::internal
