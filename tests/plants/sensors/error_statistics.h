#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <gtest/gtest.h>

namespace tenon::test {

/// Mean, standard deviation, and correlation with the sample before, of every element of an error.
template <int N>
struct ErrorStatistics {
  void Add(const Vec<N>& error) {
    ++count;
    sum += error;
    squares += error.cwiseAbs2();
    products += error.cwiseProduct(last);
    last = error;
  }
  /// Expects white noise: each statistic is within 4 of its standard deviations for normal numbers.
  void Expect(const Vec<N>& mean, const Vec<N>& deviation) const {
    const double n = count;
    for (int i = 0; i < N; ++i) {
      const double m = sum[i] / n;
      EXPECT_NEAR(m, mean[i], 4 * deviation[i] / std::sqrt(n)) << i;
      EXPECT_NEAR(std::sqrt(squares[i] / n - m * m) / deviation[i], 1, 4 / std::sqrt(2 * n)) << i;
      EXPECT_NEAR(products[i] / n - m * m, 0, 4 * deviation[i] * deviation[i] / std::sqrt(n)) << i;
    }
  }
  int count = 0;
  Vec<N> sum = Vec<N>::Zero(), squares = Vec<N>::Zero(), products = Vec<N>::Zero(), last = Vec<N>::Zero();
};

}  // namespace tenon::test
