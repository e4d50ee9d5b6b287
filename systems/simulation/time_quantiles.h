#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace tenon {

/// Quantiles of times, accurate to 1 %, in constant memory.
class TimeQuantiles {
 public:
  /// Limits of a histogram [us].
  static constexpr std::array kLimits{10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10'000, 20'000, 50'000};
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
  /// Returns the number of times below a limit [s].
  long Below(double limit) const {
    long below = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i)
      if (kShortest * std::exp(kWidth * (static_cast<double>(i) + 0.5)) < limit) below += counts_[i];
    return below;
  }
  long count() const { return count_; }

 private:
  static constexpr double kShortest = 1e-9, kWidth = 0.01;  // [s], and bin width of the logarithm
  std::array<long, 3000> counts_{};                         // up to 3 hours
  long count_ = 0;
};

}  // namespace tenon
