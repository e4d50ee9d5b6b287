#pragma once

#include <cstdint>
#include <string>
#include <type_traits>

namespace tenon {

/// A sampling rate, made by Hz, Seconds or Milliseconds. Its period is an exact rational number of seconds,
/// because 300 Hz, say, has no exact period in nanoseconds or in binary: all ticks of a diagram fall on
/// integers of 1 / L seconds, where L is the least common multiple of the denominators.
class Rate {
 public:
  /// The rate with a period of `numerator` / `denominator` [s]. Throws ParameterError unless it is positive.
  static Rate FromPeriod(std::int64_t numerator, std::int64_t denominator);
  /// Reports that a number is no rate.
  template <class Number>
  requires std::is_arithmetic_v<Number> Rate(Number)  // NOLINT(google-explicit-constructor)
      : Rate(1, 1) {
    static_assert(!std::is_arithmetic_v<Number>,
                  "A rate has a unit: Hz(100), Seconds(0.01) or Milliseconds(10).");
  }

  /// The period in seconds, and as a fraction in lowest terms.
  double period() const { return static_cast<double>(numerator_) / static_cast<double>(denominator_); }
  std::int64_t numerator() const { return numerator_; }
  std::int64_t denominator() const { return denominator_; }
  double hz() const { return static_cast<double>(denominator_) / static_cast<double>(numerator_); }
  friend bool operator==(const Rate&, const Rate&) = default;

 private:
  Rate(std::int64_t numerator, std::int64_t denominator) : numerator_(numerator), denominator_(denominator) {}
  std::int64_t numerator_;
  std::int64_t denominator_;
};

/// The rate of `hz` samples per second. Decimal values are exact: Hz(29.97) is 2997/100 Hz. Throws
/// ParameterError unless it is positive and, to 12 digits, a fraction with a denominator up to 10^6.
Rate Hz(double hz);
/// The rate of one sample every `seconds`.
Rate Seconds(double seconds);
/// The rate of one sample every `milliseconds`.
Rate Milliseconds(double milliseconds);

/// An offset in seconds. It converts from and to a number.
class SampleOffset {
 public:
  constexpr SampleOffset(double seconds) : seconds_(seconds) {}  // NOLINT(google-explicit-constructor)
  /// Reports that the value is no number.
  template <class T>
  requires(!std::is_arithmetic_v<T>) SampleOffset(const T&)  // NOLINT(google-explicit-constructor)
      : seconds_(0) {
    static_assert(std::is_arithmetic_v<T>,
                  "The offset of Sampled is a number of seconds: Sampled{Hz(100), 0.003}.");
  }
  constexpr operator double() const { return seconds_; }  // NOLINT(google-explicit-constructor)

 private:
  double seconds_;
};

/// Declares that a calculation runs at t = offset + k / rate, k = 0, 1, 2, …; its result is held between
/// ticks.
struct Sampled {
  Rate rate;
  SampleOffset offset = 0;  ///< [s]
};

/// The rate as text, such as "100 Hz".
std::string ToString(const Rate& rate);

}  // namespace tenon
