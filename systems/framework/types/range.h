#pragma once

#include <limits>
#include <string>

namespace tenon {

/// The values that a number may have: an interval. The ends of AtLeast, AtMost and Between belong to it,
/// those of Above and Below do not. Numbers must be finite, unless an infinite end belongs to the interval.
///
///     Range().Above(-1).AtMost(100)
///
/// A range of a vector, a list or an optional applies to each element. A default-constructed Range allows
/// every value, also NaN.
class Range {
 public:
  Range& Finite();
  Range& Above(double end);
  Range& AtLeast(double end);
  Range& Below(double end);
  Range& AtMost(double end);
  Range& Between(double first, double last) { return AtLeast(first).AtMost(last); }
  Range& Positive() { return Above(0); }
  /// Allows infinity, too, on each side that has no other end.
  Range& OrInfinite();
  /// Also calls `check`, which throws ParameterError.
  Range& Also(void (*check)(double value));
  /// Adds the remedy or the reason to the error message: "above -1: at -1 the model has no mass".
  Range& Because(const char* remedy);

  double low() const { return low_; }
  double high() const { return high_; }
  bool low_open() const { return low_open_; }    ///< whether `low` itself is outside
  bool high_open() const { return high_open_; }  ///< whether `high` itself is outside
  bool any() const { return any_; }              ///< whether every value is allowed
  bool Contains(double value) const;             ///< and passes the check
  /// The interval in words, "above -1 and at most 100 kg"; empty if it has no ends.
  std::string Text(const std::string& unit = "") const;
  /// Throws the ParameterError of a value outside, with its name and unit.
  [[noreturn]] void Refuse(double value, const std::string& name, const std::string& unit) const;

 private:
  double low_ = -std::numeric_limits<double>::infinity(), high_ = std::numeric_limits<double>::infinity();
  void (*check_)(double value) = nullptr;
  const char* remedy_ = "";
  bool low_open_ = true, high_open_ = true, any_ = true;
};

}  // namespace tenon
