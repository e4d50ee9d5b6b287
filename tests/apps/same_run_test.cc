// A program that sets only the keys of a case and uses the defaults of the library gives the run of the app,
// bit for bit.

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <gtest/gtest.h>

#include <bit>

namespace tenon::apps::same_run_test {

using Bits = std::vector<std::uint64_t>;

/// The signals that an app logs in 1.5 s.
template <class Loop, class Figures>
Bits Log(const auto& params, const std::function<SimulatorOptions(const Loop&)>& options) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Loop>("loop", params);
  Simulator simulator(builder.Build(), options(loop));
  const auto log = simulator.AddLog(Hz(1000), Figures::Signals(loop));
  simulator.RunTo(1.5);
  Bits bits;
  for (std::size_t i = 0; i < log->rows(); ++i)
    for (const double value : log->row(i)) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

template <class Scenario>
Scenario Read(const std::string& name, const std::string& app) {
  return LoadScenario(name, {}, app).template Read<Scenario>();
}

SimulatorOptions OptionsOf(const CdprScenario& scenario, const CdprLoop&) {
  return MakeSimulatorOptions(scenario);
}
SimulatorOptions OptionsOf(const LeggedScenario& scenario, const auto& loop) {
  return MakeSimulatorOptions(scenario, loop.world.plant);
}

/// Compares the parameters that `by_app` makes of a scenario with those of `by_hand`.
template <class Loop, class Figures>
void ExpectSameRun(const auto& scenario, const auto& by_app, const auto& by_hand) {
  const Bits app =
      Log<Loop, Figures>(by_app(scenario), [&](const Loop& loop) { return OptionsOf(scenario, loop); });
  const Bits program = Log<Loop, Figures>(by_hand, [](const Loop& loop) { return RecommendedOptions(loop); });
  EXPECT_GT(app.size(), 1000u);
  EXPECT_TRUE(app == program) << scenario.case_name;
}

QuadrupedDescription DogBot() {
  return LoadQuadruped(FindResource("robots", "dogbot"));
}

void ExpectSameWalk(const std::string& name, const QuadrupedWalkParams& by_hand) {
  ExpectSameRun<QuadrupedWalk, WalkFigures>(
      Read<QuadrupedScenario>(name, "tenon-quadruped"),
      [](const QuadrupedScenario& scenario) { return MakeWalkParams(scenario); }, by_hand);
}

WalkSegment Stand(double duration) {
  return {.gait = Gait::kStand, .duration = duration};
}
WalkSegment Trot(double length, double yaw_rate = 0) {
  return {.gait = Gait::kTrot, .forward = 0.12, .yaw_rate = yaw_rate, .length = length};
}

TEST(SameRunTest, A1) {
  const QuadrupedDescription robot = DogBot();
  QuadrupedWalkParams params = MakeQuadrupedWalk(robot);
  params.walk.segments = {Stand(0.5), Trot(1.5), Trot(1.25, 0.05), Trot(1), Trot(1.25, -0.05), Trot(0.5)};
  ExternalForce push = PointOnLeg(robot, kFrontLeft, 0.5);
  push.force_W << 20, 0, 0;
  params.world.sines = {{.amplitude = push, .angular_frequency = 1, .start = 0, .end = 100}};
  ExpectSameWalk("A1", params);
}

TEST(SameRunTest, B2) {
  const QuadrupedDescription robot = DogBot();
  QuadrupedWalkParams params = MakeQuadrupedWalk(robot);
  params.walk.segments = {Stand(0.5), Trot(3)};
  QuadrupedWorldParams& world = params.world;
  world.random = {{.robot = robot, .on_trunk = true, .lower = 2.5, .upper = 40, .period = Seconds(4)},
                  {.robot = robot, .lower = 2.5, .upper = 40, .period = Seconds(4)}};
  world.torque_sensor.error.relative = 0.1;
  world.foot_sensor.error.relative = 0.1;
  world.imu.angular_velocity_noise.setConstant(0.005);
  world.imu.specific_force_noise.setConstant(0.05);
  world.encoders.angle.absolute = 1e-4;
  ExpectSameWalk("B2", params);
}

TEST(SameRunTest, C1) {
  GuideDogParams params = MakeGuideDog(MakeQuadrupedWalk(DogBot()));
  params.walk.segments = {Stand(0.5), {.gait = Gait::kTrot, .forward = 0.12, .duration = 80}};
  params.locomotion.swing_planner.step.free_shift = 0;
  params.locomotion.swing_planner.step.shift_bandwidth = 30;
  params.person.start << -1.7, 0;
  params.person.phases = {{.activity = Activity::kFollow, .duration = 15, .speed = 0.07},
                          {.activity = Activity::kFollow, .duration = 25, .speed = 0.10},
                          {.activity = Activity::kFollow, .duration = 22, .speed = 0.05}};
  ExpectSameRun<GuideDog, GuideDogFigures>(Read<GuideDogScenario>("C1", "tenon-guide-dog"),
                                           MakeGuideDogParams, params);
}

/// The robot and the path of D1.
CdprLoopParams Circle() {
  CdprLoopParams params{.robot = LoadCdpr(FindResource("robots", "cdpr_4"))};
  params.path = std::make_shared<EquilibriumPath>(params.robot, Path::Circle({0, 0, 2}, 0.5, 10, 0.5));
  return params;
}

TEST(SameRunTest, D1) {
  CdprLoopParams params = Circle();
  params.mpc.emplace();
  params.mpc->path = params.path;
  params.mpc->horizon = 1.2;
  params.mpc->weights = {.position = Vec<3>::Constant(3000),
                         .velocity = Vec<3>::Constant(100),
                         .attitude = Vec<3>::Constant(80),
                         .angular_velocity = Vec<3>::Constant(0.5),
                         .tension = 3e-3};
  ExpectSameRun<CdprLoop, CdprFigures>(Read<CdprScenario>("D1", "tenon-cdpr"), MakeLoopParams, params);
}

// A PD controller with the load estimator.
TEST(SameRunTest, D1WithPd) {
  CdprLoopParams params = Circle();
  params.pd_stiffness_N_per_m = 3833;
  params.pd_damping_N_s_per_m = 343;
  params.offset_free = true;
  auto scenario = Read<CdprScenario>("D1", "tenon-cdpr");
  scenario.controller = CdprController::kPdOffsetFree;
  ExpectSameRun<CdprLoop, CdprFigures>(scenario, MakeLoopParams, params);
}

TEST(SameRunTest, Stand) {
  const QuadrupedStandParams params = MakeQuadrupedStand(DogBot());
  ExpectSameRun<QuadrupedStand, StandFigures>(
      Read<QuadrupedScenario>("stand", "tenon-quadruped"),
      [](const QuadrupedScenario& scenario) { return MakeStandParams(scenario); }, params);
}

}  // namespace tenon::apps::same_run_test
