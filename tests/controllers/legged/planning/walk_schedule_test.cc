#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::walk_schedule_test {

WalkScheduleParams Example() {
  return YamlDocument::Parse(R"(
segments:
  - {gait: stand, duration_s: 0.5}
  - {gait: trot, forward_m_per_s: 0.12, length_m: 2}
  - {gait: trot, forward_m_per_s: 0.12, yaw_rate_rad_per_s: 0.05, length_m: 3.5}
  - {gait: pace, left_m_per_s: 0.1, duration_s: 4}
acceleration_m_per_s2: 0.3
)",
                             "walk.yaml")
      .Read<WalkScheduleParams>();
}

// 2 m and 3.5 m, and 4 s of pacing: from 0.12 m/s forwards to 0.1 m/s to the left on a ramp of 0.52 s. The
// arc turns at 0.05 rad/s for as long as 3.5 m take, less half of its ramp, and half of the next.
TEST(WalkScheduleTest, ComputesLengthAndTurn) {
  const WalkSchedule::Extent extent = WalkSchedule(Example()).extent();
  const double ramp = std::hypot(0.12, 0.1) / 0.3;
  const auto speed = [](double s) { return std::hypot(0.12 * (1 - s), 0.1 * s); };
  const double pacing = ramp / 6 * (speed(0) + 4 * speed(0.5) + speed(1)) + 0.1 * (4 - ramp);
  EXPECT_NEAR(extent.length, 2 + 3.5 + pacing, 1e-12);
  EXPECT_NEAR(extent.turn, 0.05 * (3.5 / 0.12 - 0.05 / 2) + 0.05 * ramp / 2, 1e-12);
}

TEST(WalkScheduleTest, GoesTheLengthsOnRamps) {
  TestRig<WalkSchedule> rig(Example());
  double way = 0, last_speed = 0, last_yaw_rate = 0, turn = 0;
  double straight_ends = 0, arc_ends = 0;
  for (int n = 0; rig.time() < rig->end_time() - 4.02; ++n) {
    rig.Tick();
    const WalkCommand& command = rig[rig->command];
    EXPECT_EQ(command.gait, n < 50 ? Gait::kStand : Gait::kTrot) << n;
    EXPECT_LE(std::abs(command.forward - last_speed), 0.3 * 0.01 + 1e-12) << n;
    EXPECT_LE(std::abs(command.yaw_rate - last_yaw_rate), 0.01 + 1e-12) << n;
    way += 0.01 * (command.forward + last_speed) / 2;
    turn += 0.01 * (command.yaw_rate + last_yaw_rate) / 2;
    last_speed = command.forward;
    last_yaw_rate = command.yaw_rate;
    if (last_yaw_rate == 0) straight_ends = way;
    arc_ends = way;
  }
  EXPECT_NEAR(straight_ends, 2, 0.003);
  EXPECT_NEAR(arc_ends, 5.5, 0.003);
  EXPECT_NEAR(turn, 0.05 * 3.5 / 0.12, 0.003);
}

TEST(WalkScheduleTest, StandsAfterTheLastSegment) {
  TestRig<WalkSchedule> rig(Example());
  const double end = rig->end_time();
  EXPECT_NEAR(end, 0.5 + 0.4 + (2 - 0.024) / 0.12 + 3.5 / 0.12 + 4, 1e-12);
  EXPECT_NEAR(rig->last_ramp_end(), end - 4 + std::hypot(0.12, 0.1) / 0.3, 1e-12);
  rig.RunTo(end - 1);
  EXPECT_EQ(rig[rig->command].gait, Gait::kPace);
  EXPECT_EQ(rig[rig->command].left, 0.1);
  EXPECT_EQ(rig[rig->command].forward, 0);
  rig.RunTo(end + 0.02);
  EXPECT_EQ(rig[rig->command].gait, Gait::kStand);
  EXPECT_EQ(rig[rig->command].left, 0);
}

// A sine in the middle and rest at both ends; the rates are the derivatives of the height.
TEST(WalkScheduleTest, SquatsBeginAndEndAtRest) {
  TestRig<WalkSchedule> rig(WalkScheduleParams{
      .segments = {{.duration = 8, .squat_amplitude = 0.08, .squat_frequency = 0.5}}, .rate = Hz(1000)});
  const auto at = [&](double t) {
    rig.RunTo(t);
    return rig[rig->command].height;
  };
  EXPECT_EQ(at(0), Vec<3>(0, 0, 0));
  Vec<3> before = at(0.1), now = at(0.101), after = at(0.102);
  EXPECT_NEAR((after[0] - before[0]) / 0.002, now[1], 1e-4);
  EXPECT_NEAR((after[1] - before[1]) / 0.002, now[2], 1e-3);
  EXPECT_NEAR(at(4.5)[0], 0.08, 1e-9);
  EXPECT_NEAR(at(5.5)[0], -0.08, 1e-9);
  before = at(7), now = at(7.001), after = at(7.002);
  EXPECT_NEAR((after[0] - before[0]) / 0.002, now[1], 1e-4);
  EXPECT_LT(at(7.999).norm(), 1e-3);
}

TEST(WalkScheduleTest, RefusesNonsense) {
  const auto refuses = RefusesChanged<WalkSchedule>(Example());
  EXPECT_TRUE(refuses([](auto& p) { p.segments.clear(); }, "segments"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[1].duration = 1; }, "segments.1"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[0].duration.reset(); }, "segments.0"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[2].length = -1; }, "segments.2"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[0].forward = 1; }, "segments.0"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[1].forward = 0; }, "segments.1"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[1].length = 0.01; }, "segments.1"));
  EXPECT_TRUE(
      refuses([](auto& p) { p.segments[0].squat_frequency = 0; }, "segments.0", "squat_frequency_hz"));
  EXPECT_TRUE(refuses([](auto& p) { p.segments[0].squat_amplitude = 0.1; }, "segments.0"));
}

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

TEST(WalkDriveTest, AnActiveRequestOverridesThePlanAndTheParameters) {
  TestRig<WalkDrive> rig(WalkDriveParams{});
  rig.Fix(rig->planned, {.gait = Gait::kStand});
  rig.Set(rig->active, true).Set(rig->velocity, {0.3, 0, 0}).Set(rig->stands, true);
  rig.Fix(rig->request, {.active = true, .velocity = {-0.2, 0, 0.1}});
  for (int i = 0; i < 100; ++i) rig.Tick();
  EXPECT_NEAR(rig[rig->command].forward, -0.2, 1e-12);
  EXPECT_NEAR(rig[rig->command].yaw_rate, 0.1, 1e-12);
  EXPECT_EQ(rig[rig->command].gait, Gait::kTrot);
  rig.Set(rig->active, false).Fix(rig->request, {});
  for (int i = 0; i < 100; ++i) rig.Tick();
  EXPECT_EQ(rig[rig->command].forward, 0);
  EXPECT_EQ(rig[rig->command].gait, Gait::kStand);
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

}  // namespace tenon::walk_schedule_test
