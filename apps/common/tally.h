#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace tenon::apps {

/// Statistics of a sequence of numbers; empty without numbers, and NaN if one of them was NaN.
class Tally {
 public:
  void Add(double value) {
    low_ = count_ == 0 ? value : std::min(low_, value);
    high_ = count_ == 0 ? value : std::max(high_, value);
    sum_ += value;
    squares_ += value * value;
    ++count_;
  }
  std::optional<double> min() const { return IfAny(low_); }
  std::optional<double> max() const { return IfAny(high_); }
  std::optional<double> mean() const { return IfAny(sum_ / static_cast<double>(count_)); }
  std::optional<double> rms() const { return IfAny(std::sqrt(squares_ / static_cast<double>(count_))); }

 private:
  std::optional<double> IfAny(double figure) const {
    if (count_ == 0) return std::nullopt;
    return std::isnan(squares_) ? squares_ : figure;  // the minimum and the maximum skip NaN
  }
  long count_ = 0;
  double low_ = 0, high_ = 0, sum_ = 0, squares_ = 0;
};

/// Converts a time from s to us.
inline std::optional<double> Microseconds(std::optional<double> seconds) {
  if (seconds) *seconds *= 1e6;
  return seconds;
}

/// Quantiles of times, accurate to 1 %, in constant memory.
class TimeQuantiles {
 public:
  void Add(double seconds) {
    const double bin = std::log(seconds / kShortest) / kWidth;
    const auto last = static_cast<double>(counts_.size() - 1);
    ++counts_[bin > 0 ? static_cast<std::size_t>(std::min(bin, last)) : 0];  // NaN counts as 0
    ++count_;
  }
  /// Returns the quantile for `share` in [0, 1], in s; empty without times.
  std::optional<double> Quantile(double share) const {
    if (count_ == 0) return std::nullopt;
    const auto rank = static_cast<long>(share * static_cast<double>(count_ - 1));
    long below = 0;
    std::size_t bin = 0;
    while ((below += counts_[bin]) <= rank) ++bin;
    return kShortest * std::exp(kWidth * (static_cast<double>(bin) + 0.5));
  }

 private:
  static constexpr double kShortest = 1e-9, kWidth = 0.01;  // [s], and bin width of the logarithm
  std::array<long, 3000> counts_{};                         // up to 3 hours
  long count_ = 0;
};

}  // namespace tenon::apps
