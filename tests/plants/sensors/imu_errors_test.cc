#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::imu_errors_test {
namespace {

const ImuMeasurement kMeasurement{{0.1, -0.2, 0.3}, {0.5, 0, 9.81}};

TEST(ImuErrorsTest, WithoutErrorsItPassesItsInput) {
  TestRig<ImuErrors> rig;
  rig.Fix(rig->measurement, kMeasurement).Tick();
  EXPECT_EQ(rig[rig->measured].angular_velocity_B, kMeasurement.angular_velocity_B);
  EXPECT_EQ(rig[rig->measured].specific_force_B, kMeasurement.specific_force_B);
}

/// Gravity seen from a unit that is turned by a little about y leans forward: g sin(e) along x.
TEST(ImuErrorsTest, AUnitThatSitsAskewSeesGravityAslant) {
  TestRig<ImuErrors> rig(ImuErrorsParams{.misalignment = 1});
  rig.Fix(rig->measurement, {Vec<3>::Zero(), {0, 0, 9.81}}).Tick();
  rig.Set(rig->unit, {.turn_B = {0, 0.02, 0}}).Tick();
  EXPECT_THAT(rig[rig->measured].specific_force_B,
              IsNear(Vec<3>(-9.81 * std::sin(0.02), 0, 9.81 * std::cos(0.02)), 1e-12));
}

/// Many units: each has a bias and a place of its own.
TEST(ImuErrorsTest, UnitsDifferByTheirDeviations) {
  constexpr int kUnits = 400;
  double bias = 0, turn = 0;
  for (int seed = 1; seed <= kUnits; ++seed) {
    DiagramBuilder builder;
    auto& errors = builder.Add<ImuErrors>(
        "errors",
        ImuErrorsParams{.misalignment = 0.01, .angular_velocity_bias = 0.02, .specific_force_bias = 0.3});
    const auto diagram = builder.BuildWithOpenInputs();
    Simulator simulator(*diagram, {.seed = static_cast<std::uint64_t>(seed)});
    simulator.context().Set(errors.measurement, kMeasurement);
    simulator.RunTo(0);
    const ImuErrors::Unit& unit = simulator.context().Eval(errors.unit);
    bias += unit.specific_force_bias.squaredNorm() / (3 * kUnits);
    turn += unit.turn_B.squaredNorm() / (3 * kUnits);
  }
  EXPECT_NEAR(std::sqrt(bias), 0.3, 0.02);
  EXPECT_NEAR(std::sqrt(turn), 0.01, 0.001);
}

TEST(ImuErrorsTest, BiasesWalkWithTheRootOfTime) {
  constexpr int kTicks = 20'000;
  constexpr double kWalk = 0.05;
  TestRig<ImuErrors> rig(ImuErrorsParams{.rate = Hz(100), .angular_velocity_walk = kWalk});
  rig.Fix(rig->measurement, kMeasurement).Tick();
  Vec<3> last = rig[rig->measured].angular_velocity_B;
  double squares = 0;
  for (int n = 0; n < kTicks; ++n) {
    const Vec<3> next = rig.Tick()[rig->measured].angular_velocity_B;
    squares += (next - last).squaredNorm() / 3;
    last = next;
  }
  EXPECT_NEAR(std::sqrt(squares / (0.01 * kTicks)), kWalk, 0.02 * kWalk);
  EXPECT_EQ(rig[rig->measured].specific_force_B, kMeasurement.specific_force_B);
}

}  // namespace
}  // namespace tenon::imu_errors_test
