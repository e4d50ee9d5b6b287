#include <tenon/systems/framework/block/distribution.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::random_stream_test {

constexpr int kCount = 200000;

/// Mean, variance, skewness and kurtosis of draw().
template <class F>
std::array<double, 4> Moments(F draw) {
  std::vector<double> values(kCount);
  double mean = 0;
  for (double& value : values) mean += (value = draw()) / kCount;
  double second = 0, third = 0, fourth = 0;
  for (const double value : values) {
    const double d = value - mean;
    second += d * d / kCount;
    third += d * d * d / kCount;
    fourth += d * d * d * d / kCount;
  }
  return {mean, second, third / std::pow(second, 1.5), fourth / (second * second)};
}

TEST(RandomStreamTest, NormalHasTheMomentsOfTheNormalDistribution) {
  RandomStream stream(1);
  const auto [mean, variance, skewness, kurtosis] = Moments([&] { return stream.Normal(); });
  EXPECT_NEAR(mean, 0, 0.01);
  EXPECT_NEAR(variance, 1, 0.015);
  EXPECT_NEAR(skewness, 0, 0.02);
  EXPECT_NEAR(kurtosis, 3, 0.05);
}

TEST(RandomStreamTest, UniformFillsItsRange) {
  RandomStream stream(2);
  const auto [mean, variance, skewness, kurtosis] = Moments([&] {
    const double value = stream.Uniform();
    EXPECT_GE(value, 0);
    EXPECT_LT(value, 1);
    return value;
  });
  EXPECT_NEAR(mean, 0.5, 0.003);
  EXPECT_NEAR(variance, 1.0 / 12, 0.001);
  EXPECT_NEAR(skewness, 0, 0.02);
  EXPECT_NEAR(kurtosis, 1.8, 0.02);
  for (int i = 0; i < 1000; ++i) {
    const double value = stream.Uniform(-3, -1);
    EXPECT_GE(value, -3);
    EXPECT_LT(value, -1);
  }
}

TEST(RandomStreamTest, IsTheSameOnEveryMachine) {
  // xoshiro256++ with the state that SplitMix64 makes of seed 0; the first outputs of the authors' C code.
  RandomStream stream(0);
  EXPECT_EQ(stream.Next(), 0x53175d61490b23dfu);
  EXPECT_EQ(stream.Next(), 0x61da6f3dc380d507u);
  EXPECT_EQ(stream.Next(), 0x5c0fdf91ec9a7bfcu);
}

TEST(RandomStreamTest, SuccessiveNumbersAreUncorrelated) {
  RandomStream stream(3);
  double last = stream.Normal(), sum = 0;
  for (int i = 0; i < kCount; ++i) {
    const double next = stream.Normal();
    sum += last * next / kCount;
    last = next;
  }
  EXPECT_NEAR(sum, 0, 0.01);
}

TEST(RandomStreamTest, StreamsOfPathsAndSeedsAreIndependent) {
  const auto correlation = [](RandomStream a, RandomStream b) {
    double sum = 0;
    for (int i = 0; i < kCount; ++i) sum += a.Normal() * b.Normal() / kCount;
    return sum;
  };
  EXPECT_NEAR(correlation(RandomStream(0, "a"), RandomStream(0, "a")), 1, 0.02);
  EXPECT_NEAR(correlation(RandomStream(0, "a"), RandomStream(0, "b")), 0, 0.01);
  EXPECT_NEAR(correlation(RandomStream(0, "a"), RandomStream(1, "a")), 0, 0.01);
  EXPECT_NEAR(correlation(RandomStream(1, "a"), RandomStream(0, "b")), 0, 0.01);
}

TEST(RandomStreamTest, ACopyGoesOnAlike) {
  RandomStream stream(4);
  stream.Normal();  // a second number waits
  RandomStream copy = stream;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(copy.Normal(), stream.Normal());
  static_assert(std::is_trivially_copyable_v<RandomStream>);
}

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

}  // namespace tenon::random_stream_test
