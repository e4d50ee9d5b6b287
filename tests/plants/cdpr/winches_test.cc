// Winches, their errors, and drums with layers of cable.

#include <tenon/plants/cdpr/winch.h>
#include <tenon/plants/cdpr/winch_errors.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::winches_test {

WinchProperties Properties(WinchMode mode) {
  return {.mode = mode, .time_constant = 0.02, .reel_damping = 90, .effective_mass = 8};
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

const CableVector kCommand = Eigen::Vector4d(10, 50, 200, 0);

CableSignals Moving(const Eigen::Vector4d& rate) {
  CableSignals cables = CableSignals::Zero(4);
  cables.length_rate = rate;
  return cables;
}

TEST(WinchErrorsTest, WithoutErrorsTheyPassTheCommand) {
  TestRig<WinchErrors> rig;
  rig.Fix(rig->command, kCommand).Fix(rig->cables, Moving({1, -1, 0.1, 0})).Tick();
  EXPECT_EQ(rig[rig->tension], kCommand);
}

TEST(WinchErrorsTest, FrictionHelpsACableThatIsPulledOutAndHindersOneThatIsReeledIn) {
  TestRig<WinchErrors> rig(WinchErrorsParams{.friction = 0.1});
  rig.Fix(rig->command, kCommand).Fix(rig->cables, Moving({0.5, -0.5, 0.005, 0})).Tick();
  const Eigen::Vector4d expected(11, 45, 200 * (1 + 0.1 * std::tanh(1)), 0);
  EXPECT_THAT(Eigen::Vector4d(rig[rig->tension]), IsNear(expected, 1e-9));
}

TEST(WinchErrorsTest, EachWinchHasAConstantThatStaysAndARippleThatDoesNot) {
  TestRig<WinchErrors> rig(WinchErrorsParams{.gain_deviation = 0.05, .ripple = 0.02});
  constexpr int kTicks = 4000;
  rig.Fix(rig->command, CableVector::Constant(4, 100)).Fix(rig->cables, Moving(Eigen::Vector4d::Zero()));
  Eigen::Array4d sum = Eigen::Array4d::Zero(), squares = sum;
  for (int n = 0; n < kTicks; ++n) {
    const Eigen::Array4d tension = rig.Tick()[rig->tension].array();
    sum += tension / kTicks;
    squares += tension.square() / kTicks;
  }
  const Eigen::Array4d deviation = (squares - sum.square()).sqrt();
  EXPECT_TRUE((deviation > 1.8).all() && (deviation < 2.2).all()) << deviation.transpose();
  EXPECT_GT((sum - sum.mean()).abs().minCoeff(), 0.2) << "no two alike: " << sum.transpose();
}

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

}  // namespace tenon::winches_test
