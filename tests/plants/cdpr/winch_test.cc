#include <tenon/plants/cdpr/winch.h>
#include <tenon/tests/testing/block_test.h>

#include <algorithm>

namespace tenon::winch_test {
namespace {

WinchProperties Properties(WinchMode mode) {
  WinchProperties winch;
  winch.mode = mode;
  winch.time_constant = 0.02;
  winch.reel_damping = 90;
  winch.effective_mass = 8;
  return winch;
}

TEST(WinchTest, TensionAndRateSolveBothLaws) {
  RandomStream random(1);
  int pulls = 0, idle = 0;
  for (int i = 0; i < 100; ++i) {
    for (const WinchMode mode : {WinchMode::kTension, WinchMode::kTorque}) {
      const WinchProperties winch = Properties(mode);
      const WinchMotion motion{random.Uniform(0, 200), random.Uniform(-1, 1), random.Uniform(0.7, 1.3),
                               i % 10 == 0};
      const double strained = random.Uniform(-100, 300), damping = random.Uniform(0, 50);
      const double tension = TensionAtWinch(winch, motion, strained, damping);
      const double rate = PayOutRate(winch, motion, tension);
      EXPECT_NEAR(tension, std::max(0.0, strained - damping * rate), 1e-10);
      ++(tension > 0 ? pulls : idle);
      if (motion.stands) {
        EXPECT_EQ(rate, 0);
      } else if (mode == WinchMode::kTension) {
        EXPECT_NEAR(rate / motion.reeling, (tension - motion.motor_tension) / 90, 1e-12);
      } else {
        EXPECT_NEAR(rate / motion.reeling, motion.reel_speed, 1e-14);
      }
    }
  }
  EXPECT_GT(pulls, 60);
  EXPECT_GT(idle, 15);
}

TEST(WinchTest, ADifferentialSaturatesSumAndDifferenceOfItsCables) {
  const DifferentialProperties differential{{{0, 1}}, 100};
  RandomStream random(2);
  for (int i = 0; i < 100; ++i) {
    const double asked = random.Uniform(0, 300), other = random.Uniform(0, 300);
    const double gives = GivenByDifferential(differential, asked, other);
    const double gives_other = GivenByDifferential(differential, other, asked);
    const double sum = (gives + gives_other) / 2, difference = (gives - gives_other) / 2;  // at the motors
    EXPECT_GE(std::min(gives, gives_other), -1e-12);
    EXPECT_NEAR(sum, std::min(100.0, (asked + other) / 2), 1e-12);
    EXPECT_NEAR(difference, std::clamp((asked - other) / 2, -100.0, 100.0), 1e-12);
  }
}

TEST(WinchTest, AnEmptyDrumEndsTheRun) {
  const DrumProperties drum{
      .radius = 0.04, .cable_diameter = 0.005, .turns_per_layer = 10, .cable_length = 3};
  EXPECT_EQ(DrumTurnAt(drum, 2, 3).angle, 0);
  EXPECT_NEAR(DrumTurnAt(drum, 2, 2).angle, 25, 1e-12);
  EXPECT_TRUE(Throws<RunError>([&] { DrumTurnAt(drum, 2, 3.1); }, "cable 2", "cable_length_m"));
}

}  // namespace
}  // namespace tenon::winch_test
