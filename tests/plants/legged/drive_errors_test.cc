#include <tenon/plants/legged/drive_errors.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::drive_errors_test {

TEST(DriveErrorsTest, WithoutErrorsItPassesItsInput) {
  TestRig<DriveErrors> rig;
  const Vec<12> command = Vec<12>::LinSpaced(-6, 5);
  rig.Fix(rig->command, command).Tick();
  EXPECT_EQ(rig[rig->torque], command);
}

TEST(DriveErrorsTest, EachDriveHasAConstantThatStays) {
  TestRig<DriveErrors> rig(DriveErrorsParams{.gain_deviation = 0.1});
  rig.Fix(rig->command, Vec<12>::Constant(10)).Tick();
  const Vec<12> first = rig[rig->torque];
  EXPECT_GT((first.array() - first.mean()).abs().minCoeff(), 0) << "no two alike";
  rig.Fix(rig->command, Vec<12>::Constant(20)).Tick();
  EXPECT_NEAR((rig[rig->torque] - 2 * first).norm(), 0, 1e-12);
}

TEST(DriveErrorsTest, RippleGrowsWithTheTorque) {
  constexpr int kTicks = 5000;
  TestRig<DriveErrors> rig(DriveErrorsParams{.ripple = 0.05});
  const Vec<12> command = Vec<12>::LinSpaced(0, 33);
  rig.Fix(rig->command, command);
  Vec<12> squares = Vec<12>::Zero();
  for (int n = 0; n < kTicks; ++n) squares += (rig.Tick()[rig->torque] - command).cwiseAbs2() / kTicks;
  for (int j = 0; j < 12; ++j) EXPECT_NEAR(std::sqrt(squares[j]), 0.05 * command[j], 0.003 * command[j]) << j;
}

}  // namespace tenon::drive_errors_test
