#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace tenon {

struct Interval {
  double low = 0, high = 0;
  double width() const { return high - low; }
};

/// Wilson's score interval of a probability after `successes` of `trials` at the given confidence (J. Amer.
/// Statist. Assoc. 22, 1927), valid also for few trials and near 0 and 1. Without trials it is [0, 1]. Throws
/// ParameterError unless successes <= trials and confidence is inside (0, 1).
Interval WilsonInterval(std::size_t successes, std::size_t trials, double confidence);

struct QuantileEstimate {
  double value = 0;
  Interval interval;
};

/// The smallest of the values (which may be infinite) that at least the given share of them does not exceed,
/// and an interval between two of the ordered values that holds the quantile of their distribution at the
/// given confidence, whatever the distribution (David and Nagaraja, Order Statistics, 2003, section 7.1).
/// Too few values have infinite ends. Throws ParameterError without values, for a NaN, and unless share and
/// confidence are inside (0, 1).
QuantileEstimate EstimateQuantile(std::vector<double> values, double share, double confidence);

/// Spearman's rank correlation of two equally long lists, from -1 to 1; equal values share their rank. Empty
/// for fewer than 3 values or a constant list.
std::optional<double> RankCorrelation(std::span<const double> x, std::span<const double> y);

}  // namespace tenon
