#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gtest/gtest.h>

#include <cmath>

namespace tenon::distribution_test {

/// The mean and the standard deviation of of(x) over many draws x.
std::pair<double, double> Moments(const Distribution& distribution, double (*of)(double)) {
  constexpr int kCount = 100'000;
  RandomStream random(1);
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double value = of(distribution.Draw(random));
    sum += value;
    squares += value * value;
  }
  const double mean = sum / kCount;
  return {mean, std::sqrt(squares / kCount - mean * mean)};
}

double Itself(double value) {
  return value;
}

TEST(DistributionTest, HasTheMomentsThatItsParametersSay) {
  const auto [middle, spread] = Moments(*Distribution::Named("uniform", {2, 5}), Itself);
  EXPECT_NEAR(middle, 3.5, 0.01);
  EXPECT_NEAR(spread, 3 / std::sqrt(12), 0.01);
  const auto [mean, deviation] = Moments(*Distribution::Named("normal", {-1, 0.5}), Itself);
  EXPECT_NEAR(mean, -1, 0.01);
  EXPECT_NEAR(deviation, 0.5, 0.01);
  const auto [log_mean, log_deviation] = Moments(*Distribution::Named("lognormal", {0.3, 0.2}), std::log);
  EXPECT_NEAR(log_mean, 0.3, 0.005);
  EXPECT_NEAR(log_deviation, 0.2, 0.005);
}

TEST(DistributionTest, RefusesWhatMakesNoSense) {
  EXPECT_FALSE(Distribution::Named("cauchy", {0, 1}));
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        Distribution::Named("uniform", {2, 1})->Validate();
      },
      "uniform: [2, 1]"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        Distribution::Named("lognormal", {0, -1})->Validate();
      },
      "lognormal: [0, -1]"));
}

}  // namespace tenon::distribution_test
