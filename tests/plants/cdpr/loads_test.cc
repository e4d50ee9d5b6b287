// Loads on the platform.

#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::loads_test {

TEST(GustsTest, RiseToTheirPeaksAndFallAndAddUp) {
  TestRig<Gusts> rig(GustsParams{{{{20, 0, 0}, 1, 2}, {{0, 10, 0}, 2, 4}}});
  const auto at = [&](double time) { return rig.RunTo(time)[rig->wrench]; };
  EXPECT_THAT(at(1).force_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_THAT(at(1.5).force_W, IsNear(Vec<3>(10, 0, 0), 1e-12));
  EXPECT_THAT(at(2).force_W, IsNear(Vec<3>(20, 0, 0), 1e-12));
  EXPECT_THAT(at(2.5).force_W, IsNear(Vec<3>(10, 5 - 5 * std::sqrt(0.5), 0), 1e-12));
  EXPECT_THAT(at(4).force_W, IsNear(Vec<3>(0, 10, 0), 1e-12));
  EXPECT_THAT(at(6.5).force_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_EQ(at(7).torque_W, Vec<3>(0, 0, 0));
}

TEST(PayloadScheduleTest, HangsThePayloadFromAttachToRelease) {
  TestRig<PayloadSchedule> rig({.payload = {.mass = 5}, .attach_s = 1, .release_s = 2});
  const auto mass_at = [&](double time) { return rig.RunTo(time)[rig->payload].mass; };
  EXPECT_EQ(mass_at(0.999), 0);
  EXPECT_EQ(mass_at(1), 5);
  EXPECT_EQ(mass_at(1.999), 5);
  EXPECT_EQ(mass_at(2), 0);
}

TEST(PayloadScheduleTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<PayloadSchedule>({.attach_s = 3}, "release_s", "attach_s"));
}

TEST(PayloadScheduleTest, LoadAndTimesAreSetInARun) {
  TestRig<PayloadSchedule> rig;
  EXPECT_EQ(rig.RunTo(1)[rig->payload].mass, 0);
  rig.context().Set(rig->load, Payload{.mass = 3}, rig->attach, 1.5, rig->release, 2.0);
  EXPECT_EQ(rig.RunTo(1.49)[rig->payload].mass, 0);
  EXPECT_EQ(rig.RunTo(1.5)[rig->payload].mass, 3);
  rig.Set(rig->release, 1.8);
  EXPECT_EQ(rig.RunTo(1.8)[rig->payload].mass, 0);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->release, 1); }, "release_s = 1", "1.5"));
}

// Turned by 90 degrees about z, x_B points along y_W; the point at x_B = 0.2 m moves by w = 1 rad/s.
TEST(PlatformPullTest, PullsAtItsPointBesideOthers) {
  TestRig<PlatformPull> rig(PlatformPullParams{.stiffness = 100, .damping = 10, .max_force = 50});
  rig.Fix(rig->platform, {.p_WB = {1, 2, 3},
                          .q_WB = {std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2},
                          .w_W = {0, 0, 1}});
  rig.Fix(rig->others, {{1, 0, 0}, {0, 0, 0.5}});
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(1, 0, 0), 0));
  rig.Set(rig->grip, {true, {0.2, 0, 0}, {1, 2.2, 3.3}});
  // v = w x arm = (-0.2, 0, 0): F = (0, 0, 30) + (2, 0, 0).
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(3, 0, 30), 1e-12));
  // arm x F = (0, 0.2, 0) x (2, 0, 30) = (6, 0, -0.4)
  EXPECT_THAT(rig[rig->wrench].torque_W, IsNear(Vec<3>(6, 0, 0.1), 1e-12));
  rig.Set(rig->grip, {true, {0, 0, 0}, {1, 2, 30}});
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(1, 0, 50), 1e-12));
}

constexpr double kGravity = 9.81;

TEST(HangingLoadTest, HangsWithItsWeightAndTurnsThePlatform) {
  HangingLoadParams params{.mass = 3, .length = 2, .attachment_B = {0.2, 0, 0.1}};
  const double stretch = 3 * kGravity * 2 / params.axial_stiffness;
  params.p_W = {1.2, 0, 3.1 - 2 - stretch};
  TestRig<HangingLoad> rig(params);
  rig.Fix(rig->platform, {.p_WB = {1, 0, 3}}).Fix(rig->others, PlatformWrench{{1, 2, 3}, {4, 5, 6}});
  EXPECT_NEAR(rig[rig->tension], 3 * kGravity, 1e-9);
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(1, 2, 3 - 3 * kGravity), 1e-9));
  EXPECT_THAT(rig[rig->wrench].torque_W, IsNear(Vec<3>(4, 5 + 0.2 * 3 * kGravity, 6), 1e-9));
  rig.RunTo(1);
  EXPECT_THAT(rig[rig->load].p_W, IsNear(params.p_W, 1e-6));
}

// Small swings under a platform that rests have the period of a pendulum.
TEST(HangingLoadTest, SwingsWithThePeriodOfAPendulum) {
  HangingLoadParams params{.mass = 2, .length = 1, .axial_damping = 0};
  params.axial_stiffness = 1e6;
  constexpr double kAngle = 0.05;
  params.p_W = {std::sin(kAngle), 0, -std::cos(kAngle)};
  TestRig<HangingLoad> rig(params);
  rig.Fix(rig->platform, PlatformState{});
  const double period = 2 * std::numbers::pi * std::sqrt(1 / kGravity) * (1 + kAngle * kAngle / 16);
  rig.RunTo(period / 4);
  EXPECT_NEAR(rig[rig->load].p_W[0], 0, 2e-4);
  EXPECT_NEAR(rig[rig->load].v_W[0], -std::sqrt(2 * kGravity * (1 - std::cos(kAngle))), 2e-3);
  rig.RunTo(period);
  EXPECT_NEAR(rig[rig->load].p_W[0], params.p_W[0], 2e-4);
}

TEST(HangingLoadTest, ASlackRopePullsNothing) {
  TestRig<HangingLoad> rig(HangingLoadParams{.mass = 2, .length = 1, .p_W = {0, 0, -0.5}});
  rig.Fix(rig->platform, PlatformState{});
  EXPECT_EQ(rig[rig->tension], 0);
  rig.RunTo(0.2);
  EXPECT_NEAR(rig[rig->load].p_W[2], -0.5 - kGravity * 0.02, 1e-6);
}

// Without damping, platform, cables, rope and load keep their energy, whatever the platform does.
TEST(HangingLoadTest, KeepsEnergyWithThePlatform) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.axial_damping = 0;
  HangingLoadParams params{.mass = 3, .length = 1, .attachment_B = {0, 0.05, -0.1}, .axial_damping = 0};
  params.p_W = {0.3, 0.05, 1.9 - std::sqrt(1 - 0.09)};
  DiagramBuilder builder;
  auto& plant =
      builder.Add<CdprPlant>("plant", CdprPlantParams{.robot = robot,
                                                      .p_WB = {0, 0, 2},
                                                      .initial_tension = CableVector::Constant(4, 110),
                                                      .lock_winches = true});
  auto& load = builder.Add<HangingLoad>("load", params);
  builder.Connect(plant.platform, load.platform);
  builder.Connect(load.wrench, plant.wrench);
  const auto diagram = builder.BuildWithOpenInputs();
  auto context = diagram->CreateContext();
  context->Set(plant.command, CableVector::Constant(4, 110));
  Simulator simulator(std::move(context), {.order = 5, .rtol = 1e-10, .atol = 1e-12});
  const auto energy = [&] {
    const Context& now = simulator.context();
    const HangingLoadState& state = now.Eval(load.load);
    const double tension = now.Eval(load.tension);
    return now.Eval(plant.energy).total() + 3 * (state.v_W.squaredNorm() / 2 + kGravity * state.p_W[2]) +
           tension * tension * params.length / (2 * params.axial_stiffness);
  };
  const double before = energy();
  simulator.RunTo(0.5);
  EXPECT_GT((simulator.context().Eval(load.load).p_W - params.p_W).norm(), 0.1);
  EXPECT_NEAR(energy(), before, 1e-5);
}

}  // namespace tenon::loads_test
