#pragma once

#include <cstdint>

namespace tenon::internal {

/// An exact fraction, denominator positive.
struct Rational {
  std::int64_t numerator;
  std::int64_t denominator;
  friend bool operator==(const Rational&, const Rational&) = default;
};

/// The simplest fraction within 1e-12 of `value`, which must be 0 or more; throws ParameterError that names
/// `what` if there is none with a denominator up to 10^6.
Rational ToRational(double value, const char* what, const char* unit = "s");

}  // namespace tenon::internal
