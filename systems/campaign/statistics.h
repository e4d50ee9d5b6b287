#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace tenon {

struct Interval {
  double low = 0, high = 0;
  double width() const { return high - low; }
};

/// Wilson's score interval of a probability after `successes` of `trials` at the given confidence (J. Amer.
/// Statist. Assoc. 22, 1927), valid also for few trials and near 0 and 1. Without trials it is [0, 1]. Throws
/// ParameterError unless successes <= trials and confidence is inside (0, 1).
Interval WilsonInterval(std::size_t successes, std::size_t trials, double confidence);

/// Spearman's rank correlation of two equally long lists, from -1 to 1; equal values share their rank. Empty
/// for fewer than 3 values or a constant list.
std::optional<double> RankCorrelation(std::span<const double> x, std::span<const double> y);

}  // namespace tenon
