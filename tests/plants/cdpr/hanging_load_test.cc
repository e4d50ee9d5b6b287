#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::hanging_load_test {
namespace {

constexpr double kGravity = 9.81;

TEST(HangingLoadTest, HangsWithItsWeightAndTurnsThePlatform) {
  HangingLoadParams params{.mass = 3, .length = 2, .attachment_B = {0.2, 0, 0.1}};
  const double stretch = 3 * kGravity * 2 / params.axial_stiffness;
  params.p_W = {1.2, 0, 3.1 - 2 - stretch};
  TestRig<HangingLoad> rig(params);
  PlatformState platform;
  platform.p_WB = {1, 0, 3};
  rig.Fix(rig->platform, platform).Fix(rig->others, PlatformWrench{{1, 2, 3}, {4, 5, 6}});
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

TEST(HangingLoadTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<HangingLoad>({.gravity = NAN}, "gravity"));
  EXPECT_TRUE(Refuses<HangingLoad>({.axial_stiffness = 0}, "axial_stiffness"));
  EXPECT_TRUE(Refuses<HangingLoad>({.axial_damping = -1}, "axial_damping"));
  EXPECT_TRUE(Refuses<HangingLoad>({.p_W = {NAN, 0, 0}}, "p_W"));
}

}  // namespace
}  // namespace tenon::hanging_load_test
