#include <tenon/systems/primitives/uniform_noise.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::uniform_noise_test {

TEST(UniformNoiseTest, HasItsMomentsAndLimits) {
  TestRig<UniformNoise<Vec<2>>> rig({.lower = {-1, 4}, .upper = {3, 5}, .unit = "m, N"});
  constexpr int kSamples = 10000;
  Vec<2> sum = Vec<2>::Zero(), squares = Vec<2>::Zero(), least(3, 5), most(-1, 4);
  for (int i = 0; i < kSamples; ++i) {
    const Vec<2> y = rig.Tick()[rig->y];
    sum += y - Vec<2>(1, 4.5);
    squares += (y - Vec<2>(1, 4.5)).cwiseAbs2();
    least = least.cwiseMin(y), most = most.cwiseMax(y);
  }
  const double error = 5 / std::sqrt(kSamples);  // standard errors of the mean
  EXPECT_NEAR(sum[0] / kSamples, 0, error * std::sqrt(16. / 12));
  EXPECT_NEAR(sum[1] / kSamples, 0, error * std::sqrt(1. / 12));
  EXPECT_NEAR(squares[0] / kSamples * 12 / 16, 1, error);
  EXPECT_NEAR(squares[1] / kSamples * 12, 1, error);
  EXPECT_GE(least[0], -1);
  EXPECT_LT(least[0], -0.99);
  EXPECT_LT(most[1], 5);
  EXPECT_GT(most[1], 4.99);
}

TEST(UniformNoiseTest, LimitsAreSetInARun) {
  TestRig<UniformNoise<>> rig;
  rig.Tick().context().Set(rig->lower, 7, rig->upper, 7.0);
  EXPECT_EQ(rig.Tick()[rig->y], 7);
}

TEST(UniformNoiseTest, RefusesBadLimits) {
  EXPECT_TRUE(Refuses<UniformNoise<>>({.lower = 2}, "lower"));
  EXPECT_TRUE(Refuses<UniformNoise<>>({.lower = test::kNan}, "lower"));
}

}  // namespace tenon::uniform_noise_test
