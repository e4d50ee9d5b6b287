#pragma once

#include <cstdint>
#include <string>

namespace tenon {

/// An exact, positive or zero, rational number of seconds. Sample times are kept so because 300 Hz, say, has
/// no exact period in nanoseconds or in binary: all ticks of a diagram fall on integers of 1 / L seconds, L
/// being the least common multiple of the denominators.
class Rate {
 public:
  /// The period `numerator` / `denominator` [s]; throws ParameterError unless it is positive.
  Rate(std::int64_t numerator, std::int64_t denominator);

  double period() const { return static_cast<double>(numerator_) / static_cast<double>(denominator_); }
  double hz() const { return static_cast<double>(denominator_) / static_cast<double>(numerator_); }
  std::int64_t numerator() const { return numerator_; }
  std::int64_t denominator() const { return denominator_; }
  friend bool operator==(const Rate&, const Rate&) = default;

 private:
  std::int64_t numerator_;
  std::int64_t denominator_;
};

/// The rate of `hz` samples a second. Decimal values are taken as written: Hz(29.97) is 2997/100 Hz.
/// Throws ParameterError if not positive, or if no denominator up to 10^6 gives it to 12 digits.
Rate Hz(double hz);
/// The rate of one sample every `seconds`.
Rate Seconds(double seconds);
/// The rate of one sample every `milliseconds`.
Rate Milliseconds(double milliseconds);

/// Declares that a calculation runs at t = offset + k / rate, k = 0, 1, 2, …; its result is held between.
struct Sampled {
  Rate rate;
  double offset = 0;  ///< [s]
};

/// "100 Hz", for messages and graphs.
std::string ToString(const Rate& rate);

}  // namespace tenon
