// A Go2 in MuJoCo is walked by a controller in another process, over DDS in lock-step. The controller has
// inertial unit, encoders and motor torques with the errors of standard hardware, and an estimator.

#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>
#include <tenon/tests/apps/mujoco_engine.h>
#include <tenon/tests/systems/dds/dds_peer.h>

#include <fmt/core.h>
#include <gmock/gmock.h>

namespace tenon::two_simulators_test {

using test::kOwnLink;

constexpr double kEnd = 60;  // [s]

apps::QuadrupedScenario Scenario(bool pushed) {
  std::vector<std::string> settings{
      "robot=go2",
      "hardware=standard",
      "scale_forces=true",
      "walk.state=estimated",
      "sensors.foot_force.mounted=none",
      "deployment={initial: walk}",
      "walk.path.segments=[{gait: stand, duration_s: 0.5}, {gait: trot, forward_m_per_s: 0.12, duration_s: "
      "60}]"};
  if (!pushed) settings.emplace_back("random_forces=[]");
  const auto scenario = apps::LoadScenario("A4", settings, "tenon-quadruped").Read<apps::QuadrupedScenario>();
  return ScaledToRobot(scenario, RatioOf(scenario));
}

/// A walk, judged by the true state of the robot.
struct Walked {
  std::string end;  ///< why it ended early; empty if it did not
  double distance = 0, sideways = 0, tilt = 0;
};
std::ostream& operator<<(std::ostream& out, const Walked& w) {
  return out << fmt::format("{:.3f} m, {:+.3f} m to the side, tilt {:.3f} rad{}", w.distance, w.sideways,
                            w.tilt, w.end.empty() ? "" : ": " + w.end);
}

Walked Follow(DiagramBuilder& builder, const QuadrupedWorld& world, std::uint64_t seed) {
  test::MujocoEngine().Replace(builder, world);
  Simulator simulator(builder.Build(), {.seed = seed});
  const auto log = simulator.AddLog(Hz(100), {&world.state});
  Walked walked;
  try {
    walked.end = simulator.AdvanceTo(kEnd).reason;
  } catch (const RunError& error) {
    walked.end = error.what();
  }
  const LeggedState& end = simulator.context().Eval(world.state);
  walked.distance = end.p_WB[0];
  walked.sideways = end.p_WB[1];
  const std::vector<double> x = log->column(world.state.path() + ".q_WB.x"),
                            y = log->column(world.state.path() + ".q_WB.y");
  for (std::size_t i = 0; i < x.size(); ++i)
    walked.tilt = std::max(walked.tilt, 2 * std::asin(std::min(1.0, std::hypot(x[i], y[i]))));
  return walked;
}

Walked Alone(const QuadrupedWalkParams& params, std::uint64_t seed) {
  DiagramBuilder builder;
  return Follow(builder, builder.Add<QuadrupedWalk>("walk", params).world, seed);
}

/// A robot whose blocks have the paths of those in a QuadrupedWalk, and so the same noise and pushes.
struct Robot final : Subdiagram {
  explicit Robot(const QuadrupedWorldParams& params) : world(Add<QuadrupedWorld>("world", params)) {}
  QuadrupedWorld& world;
};

Walked OverDds(const QuadrupedWalkParams& params, std::uint64_t seed) {
  test::SecondProcess controller([&] {
    alarm(600);
    DiagramBuilder builder;
    auto& walk = builder.Add<QuadrupedWalk>("walk", params);
    DriveUnitree(builder, walk, {.link = kOwnLink, .initial = params.world.plant.initial, .lock_step = true});
    Simulator(builder.Build(), {.seed = seed}).RunTo(kEnd);
  });
  DiagramBuilder builder;
  auto& world = builder.Add<Robot>("walk", params.world).world;
  auto& server = builder.Add<UnitreeServer>("server", {.link = kOwnLink, .lock_step = true});
  builder.Connect(world.joints, server.joints);
  builder.Connect(server.torque, world.torque);
  server.ConnectSensors(builder, world);
  Walked walked = Follow(builder, world, seed);
  if (walked.end.empty()) EXPECT_TRUE(controller.Succeeds());
  return walked;
}

/// Walks with as many seeds as the environment variable TENON_SEEDS says.
void ExpectThatAllWalk(bool pushed) {
  const char* seeds = std::getenv("TENON_SEEDS");
  const QuadrupedWalkParams params = MakeWalkParams(Scenario(pushed));
  for (int seed = 1; seed <= (seeds == nullptr ? 1 : std::stoi(seeds)); ++seed) {
    const Walked alone = Alone(params, seed), apart = OverDds(params, seed);
    std::cout << "seed " << seed << "\n  in one process " << alone << "\n  over DDS       " << apart
              << std::endl;
    EXPECT_EQ(apart.end, "");
    EXPECT_NEAR(apart.distance, alone.distance, 0.1);
  }
}

TEST(TwoSimulatorsTest, WalkForAMinute) {
  ExpectThatAllWalk(false);
}
TEST(TwoSimulatorsTest, WalkForAMinuteUnderPushes) {
  ExpectThatAllWalk(true);
}

}  // namespace tenon::two_simulators_test
