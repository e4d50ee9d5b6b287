#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::pacer_test {

PacerParams Standard() {
  PacerParams params;
  params.robot = test::DogBot();
  params.gaits = YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml").Read<GaitFile>().gaits;
  return params;
}

/// Drives that limit nothing.
PacerParams Fast() {
  PacerParams params = Standard();
  for (LegDescription& leg : params.robot.legs) leg.joints[1].speed_limit = 1000;
  return params;
}

double HipHeight(const QuadrupedDescription& robot) {
  return (robot.HipPosition(0, robot.stance) - robot.FootPosition(0, robot.stance))[2];
}

TEST(PacerTest, TimingIsThatOfTheTableAtLowSpeed) {
  const Pacer pacer(Standard());
  const GaitTiming table = pacer.params.gaits.trot.Timing();
  for (const double speed : {0.0, 0.12, 0.2}) {
    const GaitTiming timing = pacer.TimingAt(Gait::kTrot, speed);
    EXPECT_EQ(timing.num_steps, 2);
    EXPECT_EQ(timing.step, table.step);
    EXPECT_NEAR(timing.stance, table.stance, 1e-15) << speed;
    EXPECT_NEAR(timing.swing, table.swing, 1e-15) << speed;
  }
  EXPECT_EQ(pacer.TimingAt(Gait::kStand, 0).num_steps, 0);
}

TEST(PacerTest, StrideFollowsTheFroudeNumber) {
  const Pacer pacer(Fast());
  const double h = HipHeight(pacer.params.robot);
  for (const double froude : {1.0, 1.5, 2.0}) {
    const double speed = std::sqrt(froude * kGravity * h);
    EXPECT_NEAR(speed * pacer.TimingAt(Gait::kTrot, speed).cycle(), 2.3 * h * std::pow(froude, 0.3), 1e-3);
  }
}

TEST(PacerTest, TopSpeedIsWhereDrivesOrReachEnd) {
  const Pacer pacer(Standard());
  const double top = pacer.TopSpeed(Gait::kTrot), h = HipHeight(pacer.params.robot);
  const GaitTiming timing = pacer.TimingAt(Gait::kTrot, top);
  const double swing = 15.0 / 8 * top * timing.cycle() / timing.swing - top;
  EXPECT_NEAR(swing, 0.8 * 6 * h, 1e-3);  // DogBot's drives end at 6 rad/s
  const Pacer fast(Fast());
  const NominalStance stance(fast.params.robot);
  const double fast_top = fast.TopSpeed(Gait::kTrot);
  EXPECT_NEAR(fast_top * fast.TimingAt(Gait::kTrot, fast_top).leg_stance(), 1.6 * stance.reach[0], 1e-3);
  EXPECT_EQ(pacer.TopSpeed(Gait::kStand), 0);
  EXPECT_LT(fast.TopSpeed(Gait::kCrawl), fast_top);  // a foot stands during three swings
}

TEST(PacerTest, SlowsDownBeforeItStands) {
  TestRig<Pacer> rig(Fast());
  const double acceleration = 0.08 * kGravity;
  rig.Fix(rig->command, {.gait = Gait::kTrot, .forward = 1, .left = 0, .yaw_rate = 0});
  rig.Tick();
  WalkCommand last = rig[rig->paced];
  int ticks = 1;
  for (; ticks < 3000 && rig[rig->paced].forward < 1; ++ticks) {
    rig.Tick();
    EXPECT_LE(rig[rig->paced].forward - last.forward, 1e-3 * acceleration + 1e-12);
    last = rig[rig->paced];
  }
  EXPECT_NEAR(ticks, 1000 / acceleration, 2);
  rig.Fix(rig->command, WalkCommand());
  rig.Tick();
  for (ticks = 1; ticks < 3000 && rig[rig->paced].gait != Gait::kStand; ++ticks) rig.Tick();
  EXPECT_NEAR(ticks, 1000 / acceleration, 2);
  EXPECT_NEAR(rig[rig->paced].forward, 0, 1e-9);
}

TEST(PacerTest, KeepsItsGaitUntilTheNextOneCanFollow) {
  TestRig<Pacer> rig(Fast());
  rig.Fix(rig->command, {.gait = Gait::kTrot, .forward = 1.7, .left = 0, .yaw_rate = 0});
  for (int i = 0; i < 3000; ++i) rig.Tick();
  rig.Fix(rig->command, {.gait = Gait::kCrawl, .forward = 1.7, .left = 0, .yaw_rate = 0});
  rig.Tick();
  EXPECT_EQ(rig[rig->paced].gait, Gait::kTrot);
  for (int i = 0; i < 3000; ++i) rig.Tick();
  EXPECT_EQ(rig[rig->paced].gait, Gait::kCrawl);
  EXPECT_NEAR(rig[rig->paced].forward, rig->TopSpeed(Gait::kCrawl), 1e-9);
  EXPECT_EQ(rig[rig->timing].num_steps, 4);
}

TEST(PacerTest, RefusesParametersOutOfRange) {
  PacerParams params = Standard();
  params.pace.acceleration = 0;
  EXPECT_TRUE(Throws<ParameterError>([&] { Pacer pacer(params); }, "acceleration_g"));
}

}  // namespace tenon::pacer_test
