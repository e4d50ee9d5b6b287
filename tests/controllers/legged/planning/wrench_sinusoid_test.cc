#include <tenon/controllers/legged/planning/wrench_sinusoid.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

namespace tenon::wrench_sinusoid_test {

constexpr double kStep = 0.01, kTwoPi = 2 * std::numbers::pi;

/// A mean plus a sinusoid along one direction, with noise.
struct Signal {
  double hertz, mean, amplitude, noise;
  Vec<6> At(double t) const {
    Vec<6> y = Vec<6>::Zero();
    y[1] = mean + amplitude * std::sin(kTwoPi * hertz * t);
    y[3] = -0.5 * y[1];
    return y;
  }
};

/// The largest error of a forecast over 0.6 s in the second after `end`, over the amplitude. The error
/// of a wrench which is held comes to 2.
double ForecastError(const Signal& signal, double end) {
  WrenchSinusoid sinusoid;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, signal.noise);
  double worst = 0;
  for (int n = 0; n * kStep < end + 1; ++n) {
    const double t = n * kStep;
    Vec<6> measured = signal.At(t);
    for (double& y : measured) y += noise(random);
    sinusoid.Update(measured, kStep);
    if (t < end) continue;
    for (const double ahead : {0.0, 0.2, 0.4, 0.6})
      worst = std::max(worst, (sinusoid.After(ahead) - signal.At(t + ahead)).norm());
  }
  return worst / signal.amplitude;
}

TEST(WrenchSinusoidTest, ForecastsMeanAndSinusoidAfterAFewPeriods) {
  EXPECT_LT(ForecastError({.hertz = 0.25, .mean = 0, .amplitude = 0.1, .noise = 0}, 16), 0.15);
  EXPECT_LT(ForecastError({.hertz = 0.5, .mean = 0.05, .amplitude = 0.1, .noise = 0}, 10), 0.15);
  EXPECT_LT(ForecastError({.hertz = 1, .mean = -0.1, .amplitude = 0.1, .noise = 0}, 8), 0.15);
  EXPECT_LT(ForecastError({.hertz = 2, .mean = 0.1, .amplitude = 0.1, .noise = 0}, 8), 0.25);
  EXPECT_LT(ForecastError({.hertz = 1, .mean = 0.1, .amplitude = 0.1, .noise = 0.003}, 8), 0.3);
}

TEST(WrenchSinusoidTest, AConstantWrenchIsItsMean) {
  const Vec<6> wrench = Vec<6>::LinSpaced(-0.1, 0.2);
  WrenchSinusoid sinusoid;
  for (int n = 0; n < 2000; ++n) sinusoid.Update(wrench, kStep);
  EXPECT_LT((sinusoid.mean - wrench).norm(), 1e-3);
  for (const double ahead : {0.0, 0.3, 0.6}) EXPECT_LT((sinusoid.After(ahead) - wrench).norm(), 1e-3);
}

TEST(WrenchSinusoidTest, NoiseAloneKeepsTheFrequencyWithinItsLimits) {
  WrenchSinusoid sinusoid;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 1);
  for (int n = 0; n < 5000; ++n) {
    Vec<6> wrench;
    for (double& y : wrench) y = noise(random);
    sinusoid.Update(wrench, kStep);
    ASSERT_GE(sinusoid.frequency, 1);
    ASSERT_LE(sinusoid.frequency, 25);
    ASSERT_LT(sinusoid.After(0.5).norm(), 20);
  }
}

}  // namespace tenon::wrench_sinusoid_test
