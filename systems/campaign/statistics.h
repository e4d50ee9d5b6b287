#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace tenon {

struct Interval {
  double low = 0, high = 0;
  double width() const { return high - low; }
};

/// In which interval a probability lies of which `successes` of `trials` were seen, with `confidence`
/// (0.95): Wilson's score interval (J. Amer. Statist. Assoc. 22, 1927), which holds for few trials and near 0
/// and 1, too. [0, 1] without trials. Throws ParameterError unless successes <= trials and confidence is
/// inside (0, 1).
Interval WilsonInterval(std::size_t successes, std::size_t trials, double confidence);

/// Spearman's rank correlation of two equally long lists, from -1 to 1; equal values share their rank.
/// Nothing if there are less than 3, or if one of the lists is constant.
std::optional<double> RankCorrelation(std::span<const double> x, std::span<const double> y);

}  // namespace tenon
