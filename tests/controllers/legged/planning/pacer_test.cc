#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/controllers/legged/planning/periodic_pendulum.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::pacer_test {

PacerParams Standard() {
  return {.robot = test::DogBot(),
          .gaits = YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml").Read<GaitFile>().gaits};
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

constexpr double kFrequency = 5.02;  // rad/s

/// Far from the origin, turning, and with a ZMP that jumps about.
PeriodicPendulum Example(PlanarPath* path, double* cycle) {
  path->position_W << 120, -45;
  path->yaw = 0.7;
  path->velocity << 0.4, 0.1;
  path->yaw_rate = 0.5;
  PeriodicPendulum pendulum;
  pendulum.Begin(*path, kFrequency);
  const double durations[] = {0.15, 0.115, 0.02, 0.2};
  const Eigen::Vector2d zmps[] = {{0.01, 0.02}, {0.05, -0.11}, {0.1, 0}, {0.16, 0.09}};
  *cycle = 0;
  for (int k = 0; k < 4; ++k) {
    pendulum.Add(durations[k], path->position_W + zmps[k]);
    *cycle += durations[k];
  }
  pendulum.Solve();
  return pendulum;
}

TEST(PeriodicPendulumTest, SwaysAsTheHyperbolicCosine) {
  // ZMP at +-b for half a period each: x = +-b (1 - cosh(w (t - T/4)) / cosh(w T/4)), T/4 the middle.
  const double half = 0.265, b = 0.07;
  PeriodicPendulum pendulum;
  pendulum.Begin(PlanarPath{}, kFrequency);
  pendulum.Add(half, {0, b});
  pendulum.Add(half, {0, -b});
  pendulum.Solve();
  for (double t = 0; t < 2 * half; t += 0.013) {
    const double sign = t < half ? 1 : -1;
    const double in_half = (t < half ? t : t - half) - half / 2;
    const double x = sign * b * (1 - std::cosh(kFrequency * in_half) / std::cosh(kFrequency * half / 2));
    const double v =
        -sign * b * kFrequency * std::sinh(kFrequency * in_half) / std::cosh(kFrequency * half / 2);
    EXPECT_THAT(pendulum.At(t).position, IsNear(Eigen::Vector2d(0, x), 1e-15)) << t;
    EXPECT_THAT(pendulum.At(t).velocity, IsNear(Eigen::Vector2d(0, v), 1e-14)) << t;
  }
}

TEST(PeriodicPendulumTest, ObeysThePendulum) {
  PlanarPath path;
  double cycle;
  const PeriodicPendulum pendulum = Example(&path, &cycle);
  const double h = 1e-4;
  for (double t = 0.001; t < 2 * cycle; t += 0.0173) {
    const PlanarPoint x = pendulum.At(t), before = pendulum.At(t - h), after = pendulum.At(t + h);
    if (pendulum.ZmpAt(t - h) != pendulum.ZmpAt(t + h)) continue;
    EXPECT_THAT(x.velocity, IsNear((after.position - before.position) / (2 * h), 1e-7)) << t;
    EXPECT_THAT(x.acceleration, IsNear((after.velocity - before.velocity) / (2 * h), 1e-6)) << t;
    EXPECT_THAT(x.acceleration, IsNear(kFrequency * kFrequency * (x.position - pendulum.ZmpAt(t)), 1e-10));
  }
}

TEST(PeriodicPendulumTest, PositionAndVelocityDoNotJump) {
  PlanarPath path;
  double cycle;
  const PeriodicPendulum pendulum = Example(&path, &cycle);
  for (const double end : {0.15, 0.265, 0.285, 0.485, 0.635, 0.75}) {
    const PlanarPoint before = pendulum.At(end - 1e-9), after = pendulum.At(end + 1e-9);
    EXPECT_THAT(before.position, IsNear(after.position, 1e-8));
    EXPECT_THAT(before.velocity, IsNear(after.velocity, 1e-7));
    EXPECT_GT((before.acceleration - after.acceleration).norm(), 0.01);  // the ZMP does
  }
}

TEST(PeriodicPendulumTest, RepeatsAlongThePath) {
  PlanarPath path;
  double cycle;
  const PeriodicPendulum pendulum = Example(&path, &cycle);
  const PlanarPath next = path.At(cycle);
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(next.yaw - path.yaw).toRotationMatrix();
  for (double t = 0.007; t < cycle; t += 0.03) {
    const PlanarPoint now = pendulum.At(t), later = pendulum.At(t + cycle);
    EXPECT_THAT(later.position, IsNear(next.position_W + R * (now.position - path.position_W), 1e-12));
    EXPECT_THAT(later.velocity, IsNear(R * now.velocity, 1e-12));
    EXPECT_THAT(later.acceleration, IsNear(R * now.acceleration, 1e-11));
  }
}

TEST(PeriodicPendulumTest, WithoutPhasesItRests) {
  PeriodicPendulum pendulum;
  const PlanarPath path{.position_W = {1, 2}};
  pendulum.Begin(path, kFrequency);
  pendulum.Add(0, {5, 5});
  pendulum.Solve();
  EXPECT_EQ(pendulum.At(7).position, path.position_W);
  EXPECT_EQ(pendulum.ZmpAt(7), path.position_W);
  EXPECT_EQ(pendulum.At(7).velocity.norm(), 0);
}

TEST(PeriodicPendulumTest, RefusesTooManyPhases) {
  PeriodicPendulum pendulum;
  for (int k = 0; k < 8; ++k) pendulum.Add(0.1, {0, 0});
  EXPECT_TRUE(Throws<RunError>([&] { pendulum.Add(0.1, {0, 0}); }, "8 phases"));
}

TEST(PlanarPathTest, GoesInCirclesAndLines) {
  PlanarPath path{.position_W = {1, 2}, .yaw = 0.3, .velocity = {0.4, 0.2}};
  for (const double rate : {0.0, 1e-6, 1e-4, 0.5, -2.0}) {
    path.yaw_rate = rate;
    const double h = 1e-5;
    for (const double t : {-1.0, 0.0, 0.7, 3.0}) {
      const PlanarPath here = path.At(t);
      const Eigen::Vector2d rate_of_position =
          (path.At(t + h).position_W - path.At(t - h).position_W) / (2 * h);
      EXPECT_THAT(rate_of_position, IsNear(here.VelocityW(), 1e-9)) << rate << " " << t;
      EXPECT_NEAR(here.yaw, 0.3 + rate * t, 1e-15);
      EXPECT_THAT(here.At(-t).position_W, IsNear(path.position_W, 1e-14));
    }
  }
  path.yaw_rate = 0.5;  // a full circle comes home
  EXPECT_THAT(path.At(4 * M_PI).position_W, IsNear(path.position_W, 1e-14));
}

}  // namespace tenon::pacer_test
