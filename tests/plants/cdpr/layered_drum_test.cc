#include <tenon/plants/cdpr/layered_drum.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tenon::layered_drum_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr DrumProperties kDrum{
    .radius = 0.036, .cable_diameter = 0.005, .turns_per_layer = 10, .cable_length = 9};

TEST(LayeredDrumTest, ALayerHoldsItsTurns) {
  EXPECT_EQ(TurnOf(kDrum, 0).angle, 0);
  EXPECT_EQ(TurnOf(kDrum, 0).radius, 0.036);
  EXPECT_NEAR(TurnOf(kDrum, 1).angle, 1 / 0.036, 1e-12);
  // Three circles that touch each other, two in one layer: their middles are D sqrt(3)/2 apart in height.
  const double second = 0.036 + std::sqrt(0.005 * 0.005 - 0.0025 * 0.0025);
  const double first_holds = 2 * kPi * 0.036 * 10;
  const DrumTurn into_second = TurnOf(kDrum, first_holds + 0.3);
  EXPECT_NEAR(into_second.radius, second, 1e-15);
  EXPECT_NEAR(into_second.angle, 20 * kPi + 0.3 / second, 1e-12);
  const DrumTurn into_third = TurnOf(kDrum, first_holds + 2 * kPi * second * 10 + 0.2);
  EXPECT_NEAR(into_third.radius, 2 * second - 0.036, 1e-15);
  EXPECT_NEAR(into_third.angle, 40 * kPi + 0.2 / into_third.radius, 1e-12);
}

TEST(LayeredDrumTest, TheAngleIsContinuousWithTheSlopeOfTheRadius) {
  const double h = 1e-4;
  for (double wound = 0; wound < 12; wound += h) {
    const DrumTurn a = TurnOf(kDrum, wound), b = TurnOf(kDrum, wound + h);
    EXPECT_GE(b.angle - a.angle, h / b.radius - 1e-12);
    EXPECT_LE(b.angle - a.angle, h / a.radius + 1e-12);
  }
}

}  // namespace
}  // namespace tenon::layered_drum_test
