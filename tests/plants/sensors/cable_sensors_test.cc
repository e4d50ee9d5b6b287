#include <tenon/plants/sensors/cable_sensors.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::cable_sensors_test {

CableSignals Cables() {
  return {Eigen::Vector4d(5.01234, 6, 7, 8), Eigen::Vector4d(0.1, -0.2, 0, 0.4),
          Eigen::Vector4d(100, 50, 0, 700), Eigen::Vector4d(5, 5.9, 7.1, 7.8)};
}

TEST(CableSensorsTest, WithoutErrorsPassTheTruth) {
  TestRig<CableSensors> rig;
  rig.Fix(rig->cables, Cables()).Tick();
  const CableSignals& measured = rig[rig->measured];
  EXPECT_EQ(measured.length, Cables().length);
  EXPECT_EQ(measured.length_rate, Cables().length_rate);
  EXPECT_EQ(measured.tension, Cables().tension);
  EXPECT_EQ(measured.rest_length, Cables().rest_length);
}

TEST(CableSensorsTest, LengthsHaveStepsAndOffsetsThatStay) {
  TestRig<CableSensors> rig(CableSensorsParams{.resolution = 0.001, .length_offset = 0.1});
  rig.Fix(rig->cables, Cables()).Tick();
  const CableVector first = rig[rig->measured].length;
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::remainder(first[i], 0.001), 0, 1e-12) << i;
  EXPECT_GT((first - Cables().length).norm(), 0.05);
  CableSignals longer = Cables();
  longer.length.array() += 0.25;
  rig.Fix(rig->cables, longer).Tick();
  EXPECT_THAT(Eigen::Vector4d(rig[rig->measured].length - first),
              IsNear(Eigen::Vector4d(Eigen::Vector4d::Constant(0.25)), 1e-9));
}

// The rate of a length that grows at 0.2 m/s follows the step response of a first-order lag.
TEST(CableSensorsTest, RatesAreFilteredDifferences) {
  TestRig<CableSensors> rig(CableSensorsParams{.rate_bandwidth = 10});
  CableSignals cables = Cables();
  const double pole = std::exp(-2 * std::numbers::pi * 10 * 1e-3);
  for (int n = 0; n < 50; ++n) {
    rig.Fix(rig->cables, cables).Tick();
    EXPECT_NEAR(rig[rig->measured].length_rate[1], 0.2 * (1 - std::pow(pole, n)), 1e-9) << n;
    cables.length[1] += 0.2e-3;
  }
}

TEST(CableSensorsTest, TensionsHaveNoiseThatGrowsWithThemAndAreNotNegative) {
  TestRig<CableSensors> rig(CableSensorsParams{.tension_noise = 0.02, .tension_offset = 5});
  rig.Fix(rig->cables, Cables());
  constexpr int kTicks = 4000;
  Eigen::Array4d mean = Eigen::Array4d::Zero(), squares = mean;
  for (int n = 0; n < kTicks; ++n) {
    const Eigen::Array4d tension = rig.Tick()[rig->measured].tension.array();
    EXPECT_GE(tension.minCoeff(), 0);
    mean += tension / kTicks;
    squares += tension.square() / kTicks;
  }
  EXPECT_NEAR(std::sqrt(squares[3] - mean[3] * mean[3]), 14, 1);
  EXPECT_GT((mean - Cables().tension.array()).abs().maxCoeff(), 2) << "offsets";
}

TEST(CableSensorsTest, RefuseSignalsOfAnotherRobot) {
  TestRig<CableSensors> rig(CableSensorsParams{.num_cables = 8});
  EXPECT_TRUE(Throws<RunError>([&] { rig.Fix(rig->cables, Cables()).Tick(); }, "CableSensors", "4", "8"));
}

TEST(CableSensorsTest, RefuseNonsense) {
  EXPECT_TRUE(Refuses<CableSensors>({.num_cables = 0}, "num_cables"));
}

}  // namespace tenon::cable_sensors_test
