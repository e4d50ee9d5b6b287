#include <tenon/systems/campaign/statistics.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>
#include <vector>

namespace tenon::statistics_test {

// 81 of 263, 15 of 148: table I of Newcombe, Statistics in Medicine 17 (1998), method 3.
TEST(WilsonIntervalTest, GivesThePublishedIntervals) {
  EXPECT_NEAR(WilsonInterval(81, 263, 0.95).low, 0.2553, 5e-5);
  EXPECT_NEAR(WilsonInterval(81, 263, 0.95).high, 0.3662, 5e-5);
  EXPECT_NEAR(WilsonInterval(15, 148, 0.95).low, 0.0624, 5e-5);
  EXPECT_NEAR(WilsonInterval(15, 148, 0.95).high, 0.1605, 5e-5);
  EXPECT_EQ(WilsonInterval(0, 20, 0.95).low, 0);
  EXPECT_NEAR(WilsonInterval(0, 20, 0.95).high, 0.1611, 5e-5);
  EXPECT_EQ(WilsonInterval(29, 29, 0.95).high, 1);
}

// At the ends, the score test is at its limit: |p - p̂| = z sqrt(p (1 - p) / n).
TEST(WilsonIntervalTest, ItsEndsSolveTheEquationOfTheScoreTest) {
  const double z = 1.6448536269514722;  // 90 %
  for (const std::size_t k : {3U, 17U, 40U}) {
    const Interval interval = WilsonInterval(k, 41, 0.9);
    for (const double p : {interval.low, interval.high})
      EXPECT_NEAR(std::abs(p - static_cast<double>(k) / 41), z * std::sqrt(p * (1 - p) / 41), 1e-12);
  }
}

TEST(WilsonIntervalTest, HoldsWhatItPromises) {
  RandomStream random(3);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    std::size_t survived = 0;
    for (int k = 0; k < 60; ++k) survived += random.Uniform() < 0.9 ? 1 : 0;
    const Interval interval = WilsonInterval(survived, 60, 0.95);
    inside += interval.low <= 0.9 && 0.9 <= interval.high ? 1 : 0;
  }
  EXPECT_NEAR(inside / 2000.0, 0.95, 0.03);
}

TEST(WilsonIntervalTest, OfNothingIsEverything) {
  EXPECT_EQ(WilsonInterval(0, 0, 0.95).low, 0);
  EXPECT_EQ(WilsonInterval(0, 0, 0.95).width(), 1);
}

TEST(WilsonIntervalTest, RefusesWhatCannotBe) {
  EXPECT_TRUE(Throws<ParameterError>([] { WilsonInterval(3, 2, 0.95); }, "3 successes of 2 trials"));
  EXPECT_TRUE(Throws<ParameterError>([] { WilsonInterval(1, 2, 95); }, "confidence = 95"));
}

std::vector<double> OneTo(int n) {
  std::vector<double> values;
  for (int i = n; i > 0; --i) values.push_back(i);
  return values;
}

// Among 10 values, the median lies between the 2nd and the 9th with a probability of 1 - 2 (1 + 10) / 2^10 =
// 97.9 %, and between the 3rd and the 8th only with 89 %.
TEST(EstimateQuantileTest, OfAMedianHasTheClosedForm) {
  const QuantileEstimate median = EstimateQuantile(OneTo(10), 0.5, 0.95);
  EXPECT_EQ(median.value, 5);
  EXPECT_EQ(median.interval.low, 2);
  EXPECT_EQ(median.interval.high, 9);
  EXPECT_EQ(EstimateQuantile(OneTo(10), 0.5, 0.89).interval.low, 3);
}

// All of n values lie below the quantile with a probability of 0.99^n, which is 2.5 % between 367 and 368.
TEST(EstimateQuantileTest, OfTooFewValuesHasNoUpperEnd) {
  EXPECT_EQ(EstimateQuantile(OneTo(367), 0.99, 0.95).interval.high, INFINITY);
  EXPECT_EQ(EstimateQuantile(OneTo(368), 0.99, 0.95).interval.high, 368);
  EXPECT_EQ(EstimateQuantile({7}, 0.01, 0.95).interval.low, -INFINITY);
  EXPECT_EQ(EstimateQuantile({7}, 0.01, 0.95).value, 7);
}

TEST(EstimateQuantileTest, HoldsWhatItPromises) {
  RandomStream random(4);
  int inside = 0, below = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> values;
    for (int k = 0; k < 200; ++k) values.push_back(random.Uniform());
    const auto [value, interval] = EstimateQuantile(values, 0.9, 0.9);
    inside += interval.low <= 0.9 && 0.9 <= interval.high ? 1 : 0;
    below += value <= 0.9 ? 1 : 0;
  }
  EXPECT_GT(inside / 2000.0, 0.9);
  EXPECT_LT(inside / 2000.0, 0.94) << "it is not wider than it must be";
  EXPECT_NEAR(below / 2000.0, 0.5, 0.08);
}

TEST(EstimateQuantileTest, CountsInfiniteValuesAndRefusesOthers) {
  EXPECT_EQ(EstimateQuantile({1, INFINITY, 2}, 0.9, 0.5).value, INFINITY);
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({}, 0.5, 0.9); }, "no values"));
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({1, NAN}, 0.5, 0.9); }, "NaN"));
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({1}, 1, 0.9); }, "share = 1"));
}

TEST(RankCorrelationTest, SeesOrderNotShape) {
  const std::vector<double> x{1, 2, 3, 4, 5}, up{1, 8, 27, 64, 125}, down{5, 4, 3, 2, -100};
  EXPECT_NEAR(*RankCorrelation(x, up), 1, 1e-15);
  EXPECT_NEAR(*RankCorrelation(x, down), -1, 1e-15);
}

// 1 - 6 sum d² / (n (n² - 1)) without ties; with them Pearson's of the shared ranks.
TEST(RankCorrelationTest, GivesTheClosedForm) {
  EXPECT_NEAR(*RankCorrelation(std::vector<double>{1, 2, 3, 4}, std::vector<double>{2, 1, 4, 3}),
              1 - 6 * 4.0 / 60, 1e-15);
  // Ranks 0.5, 0.5, 2 and 0, 1, 2.
  EXPECT_NEAR(*RankCorrelation(std::vector<double>{7, 7, 9}, std::vector<double>{1, 2, 3}), std::sqrt(3) / 2,
              1e-15);
}

TEST(RankCorrelationTest, OfNothingIsNothing) {
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, test::kNan, 3}, std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 2, 3}, std::vector<double>{test::kNan, test::kNan, 3}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 2}, std::vector<double>{1, 2}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}));
}

}  // namespace tenon::statistics_test
