#include <tenon/systems/framework/block/random_stream.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

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

}  // namespace tenon::random_stream_test
