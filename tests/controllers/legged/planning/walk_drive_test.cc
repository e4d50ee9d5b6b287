#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::walk_drive_test {
namespace {

WalkCommand Planned() {
  return {Gait::kCrawl, 0.2, -0.05, 0.1, Vec<3>(0.01, 0, 0)};
}

TEST(WalkDriveTest, PassesThePlanUntilItIsActive) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, Planned());
  for (int i = 0; i < 5; ++i) rig.Tick();
  EXPECT_EQ(rig[rig->command].gait, Gait::kCrawl);
  EXPECT_EQ(rig[rig->command].forward, 0.2);
  EXPECT_EQ(rig[rig->command].height[0], 0.01);
}

TEST(WalkDriveTest, FollowsOrdersFromWhereThePlanWasWithinTheAccelerations) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, Planned()).Tick();
  rig.Set(rig->active, true).Set(rig->velocity, Vec<3>(0.5, 0.35, -0.4)).Set(rig->gait, Gait::kPace);
  // The velocity changes by 0.5 m/s at 0.5 m/s^2 within 1 s, the yaw rate by 0.5 rad/s at 1 rad/s^2 within
  // 0.5 s.
  const Vec<3> from(0.2, -0.05, 0.1);
  for (int n = 1; n <= 150; ++n) {
    rig.Tick();
    const WalkCommand& command = rig[rig->command];
    const double s = std::min(1.0, 0.01 * n);
    EXPECT_EQ(command.gait, Gait::kPace);
    EXPECT_NEAR(command.forward, from[0] + s * 0.3, 1e-12) << n;
    EXPECT_NEAR(command.left, from[1] + s * 0.4, 1e-12) << n;
    EXPECT_NEAR(command.yaw_rate, from[2] - std::min(0.5, 0.01 * n), 1e-12) << n;
  }
}

TEST(WalkDriveTest, StandsOnceItHasSlowedDown) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, Planned()).Tick();
  rig.Set(rig->active, true).Set(rig->stands, true);
  int walking = 0;
  for (int n = 0; n < 60; ++n) {
    rig.Tick();
    const WalkCommand& command = rig[rig->command];
    const bool moves = command.forward != 0 || command.left != 0 || command.yaw_rate != 0;
    EXPECT_EQ(command.gait == Gait::kStand, !moves);
    walking += moves;
  }
  EXPECT_NEAR(walking, std::hypot(0.2, 0.05) / 0.5 / 0.01, 1);
}

// The difference from the plan decreases within the acceleration limits; then the plan passes unchanged.
TEST(WalkDriveTest, ReturnsToThePlanWithoutAJump) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, Planned()).Tick();
  rig.Set(rig->active, true).Set(rig->velocity, Vec<3>(-0.3, 0.2, -0.4)).Set(rig->height, -0.08);
  for (int n = 0; n < 300; ++n) rig.Tick();
  WalkCommand last = rig[rig->command];
  EXPECT_THAT(last.height[0], testing::DoubleNear(-0.08, 1e-4));
  rig.Set(rig->active, false);
  for (int n = 0; n < 500; ++n) {
    rig.Tick();
    const WalkCommand& command = rig[rig->command];
    EXPECT_EQ(command.gait, Gait::kCrawl);
    EXPECT_LE(std::hypot(command.forward - last.forward, command.left - last.left), 0.005 + 1e-12) << n;
    EXPECT_LE(std::abs(command.yaw_rate - last.yaw_rate), 0.01 + 1e-12) << n;
    EXPECT_LE(std::abs(command.height[0] - last.height[0]), 0.003) << n;
    last = command;
  }
  EXPECT_EQ(last.forward, Planned().forward);
  EXPECT_EQ(last.left, Planned().left);
  EXPECT_EQ(last.yaw_rate, Planned().yaw_rate);
  EXPECT_EQ(last.height, Planned().height);
}

TEST(WalkDriveTest, WalksOnUntilItHasTheSpeedOfAPlanThatStands) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, WalkCommand{}).Tick();
  rig.Set(rig->active, true).Set(rig->velocity, Vec<3>(0.2, 0, 0));
  for (int n = 0; n < 100; ++n) rig.Tick();
  rig.Set(rig->active, false);
  for (int n = 0; n < 60; ++n) {
    const WalkCommand& command = rig.Tick()[rig->command];
    EXPECT_EQ(command.gait == Gait::kStand, command.forward == 0) << n;
  }
  EXPECT_EQ(rig[rig->command].gait, Gait::kStand);
}

// Critically damped: e(t) = e(0) (1 + w t) exp(-w t), no overshoot; the rates are those of the heights.
TEST(WalkDriveTest, ChangesItsHeightWithoutOvershoot) {
  TestRig<WalkDrive> rig(WalkDriveParams{.rate = Hz(1000)});
  rig.Fix(rig->planned, WalkCommand{}).Tick();
  rig.Set(rig->active, true).Set(rig->height, -0.08);
  Vec<3> last = Vec<3>::Zero();
  for (int n = 0; n <= 2000; ++n) {
    rig.Tick();
    const Vec<3>& height = rig[rig->command].height;
    const double wt = 5 * 1e-3 * n;
    EXPECT_NEAR(height[0], -0.08 * (1 - (1 + wt) * std::exp(-wt)), 2e-4) << n;
    EXPECT_GE(height[0], -0.08 - 1e-9);
    if (n > 0) {
      EXPECT_NEAR(height[0], last[0] + 1e-3 * last[1], 1e-12);
      EXPECT_NEAR(height[1], last[1] + 1e-3 * last[2], 1e-12);
    }
    last = height;
  }
}

TEST(WalkDriveTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<WalkDrive>({.acceleration = 0}, "acceleration_m_per_s2"));
  EXPECT_TRUE(Refuses<WalkDrive>({.yaw_acceleration = -1}, "yaw_acceleration_rad_per_s2"));
  EXPECT_TRUE(Refuses<WalkDrive>({.height_bandwidth = 60}, "50 rad/s"));
  EXPECT_TRUE(Refuses<WalkDrive>({.gait = Gait::kStand}, "`stands`"));
}

}  // namespace
}  // namespace tenon::walk_drive_test
