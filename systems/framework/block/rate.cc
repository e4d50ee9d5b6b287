#include <tenon/systems/framework/block/internal/rational.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <cmath>
#include <numeric>

namespace tenon {

namespace internal {

Rational ToRational(double value, const char* what, const char* unit) {
  constexpr double kTolerance = 1e-12;
  constexpr std::int64_t kMaxDenominator = 1'000'000;
  if (!(value >= 0) || value > 1e9) {
    throw ParameterError(
        fmt::format("{} of {} {} is out of range: give a number from 0 to 1e9", what, value, unit));
  }
  // Continued fraction: the convergents p/q are the best approximations for their size.
  std::int64_t p0 = 0, q0 = 1, p1 = 1, q1 = 0;
  for (double rest = value;;) {
    const double whole = std::floor(rest);
    if (whole > 1e15) break;
    const auto a = static_cast<std::int64_t>(whole);
    const std::int64_t p2 = a * p1 + p0, q2 = a * q1 + q0;
    if (q2 > kMaxDenominator) break;
    p0 = p1, q0 = q1, p1 = p2, q1 = q2;
    if (std::abs(static_cast<double>(p1) / static_cast<double>(q1) - value) <= kTolerance * value) {
      return {p1, q1};
    }
    rest = 1 / (rest - whole);
  }
  throw ParameterError(
      fmt::format("{} of {} {} is not a fraction with a denominator up to {}: ticks are exact fractions of "
                  "a second, so round it",
                  what, value, unit, kMaxDenominator));
}

}  // namespace internal

Rate Rate::FromPeriod(std::int64_t numerator, std::int64_t denominator) {
  if (numerator <= 0 || denominator <= 0) {
    throw ParameterError(fmt::format("a sample period of {}/{} s is not positive: give a rate above 0 Hz",
                                     numerator, denominator));
  }
  const double period = static_cast<double>(numerator) / static_cast<double>(denominator);
  if (period > 1e9 || period < 1e-12) {
    throw ParameterError(fmt::format(
        "a sample period of {}/{} s is out of range: give one from 1e-12 to 1e9 s", numerator, denominator));
  }
  const std::int64_t divisor = std::gcd(numerator, denominator);
  return Rate(numerator / divisor, denominator / divisor);
}

Rate Hz(double hz) {
  if (!(hz > 0) || !std::isfinite(hz)) {
    throw ParameterError(
        fmt::format("a rate of {} Hz is not positive and finite: give a rate above 0 Hz", hz));
  }
  const internal::Rational ratio = internal::ToRational(hz, "a rate", "Hz");
  return Rate::FromPeriod(ratio.denominator, ratio.numerator);
}

Rate Seconds(double seconds) {
  if (!(seconds > 0) || !std::isfinite(seconds)) {
    throw ParameterError(
        fmt::format("a sample period of {} s is not positive and finite: give a period above 0 s", seconds));
  }
  const internal::Rational ratio = internal::ToRational(seconds, "a sample period");
  return Rate::FromPeriod(ratio.numerator, ratio.denominator);
}

Rate Milliseconds(double milliseconds) {
  return Seconds(milliseconds / 1000);
}

std::string ToString(const Rate& rate) {
  return fmt::format("{:g} Hz", rate.hz());
}

}  // namespace tenon
