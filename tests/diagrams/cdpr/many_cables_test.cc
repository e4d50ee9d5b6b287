// Robots with more or fewer cables than any shipped one, read from YAML.

#include <tenon/plants/signals/euler.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <Eigen/Geometry>

namespace tenon::many_cables_test {

/// A robot with this number of cables, read from a file.
CdprDescription RobotFromFile(int cables) {
  CdprDescription robot = test::TwoRingRobot(cables);
  robot.cable.tension_min = 1;
  const auto file = test::TemporaryPath("robot.yaml");
  std::ofstream(file) << WriteYaml(robot);
  robot = LoadCdpr(file);
  std::filesystem::remove(file);
  return robot;
}

CdprLoopParams Circle(const CdprDescription& robot, bool mpc) {
  const auto path = std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.1, 4, 0.5),
                                                      StaticsOptions{.attitude = Eigen::Vector3d::Zero()});
  CdprLoopParams params = test::WithPd(robot, path);
  if (mpc) {
    params.mpc = test::WithMpc(robot, path).mpc;
    params.mpc->horizon = 0.5;
    params.mpc->num_steps = 10;
  }
  return params;
}

class ManyCables : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Robots, ManyCables, ::testing::Values(12, 16), ::testing::PrintToStringParamName());

// Force and torque of the cables balance the weight, and the plant rests at this pose.
TEST_P(ManyCables, RestInBalance) {
  const CdprDescription robot = RobotFromFile(GetParam());
  ASSERT_EQ(robot.num_cables(), GetParam());
  for (const bool free : {false, true}) {
    StaticsOptions options;
    if (!free) options.attitude = Eigen::Vector3d(0.05, -0.03, 0.1);
    const StaticEquilibrium rest = SolveInverseGeometricoStatic(robot, {0.3, -0.2, 1.8}, options);
    Eigen::Vector3d force(0, 0, -9.81 * robot.mass), torque = Eigen::Vector3d::Zero();
    for (int i = 0; i < robot.num_cables(); ++i) {
      const Eigen::Vector3d arm = RotationFromEuler(rest.euler) * robot.cables[i].attachment_B;
      const Eigen::Vector3d pull =
          rest.tension[i] * (robot.cables[i].anchor_W - rest.p_WB - arm).normalized();
      force += pull;
      torque += arm.cross(pull);
      EXPECT_GE(rest.tension[i], 1);
    }
    EXPECT_THAT(force, IsNear(Eigen::Vector3d(0, 0, 0), 1e-9));
    EXPECT_THAT(torque, IsNear(Eigen::Vector3d(0, 0, 0), 1e-9));

    DiagramBuilder builder;
    auto& plant = builder.Add<CdprPlant>("plant", CdprPlantParams{.robot = robot,
                                                                  .p_WB = rest.p_WB,
                                                                  .euler = rest.euler,
                                                                  .initial_tension = rest.tension,
                                                                  .lock_winches = true});
    const auto diagram = builder.BuildWithOpenInputs();
    auto context = diagram->CreateContext();
    context->Set(plant.command, rest.tension);
    Simulator simulator(std::move(context), {.order = 5, .rtol = 1e-9, .atol = 1e-11});
    simulator.RunTo(0.5);
    EXPECT_THAT(simulator.context().Eval(plant.platform).p_WB, IsNear(rest.p_WB, 1e-8));
  }
}

TEST_P(ManyCables, FollowTheCircleUnderPdAndMpc) {
  const CdprDescription robot = RobotFromFile(GetParam());
  for (const bool mpc : {false, true}) {
    SCOPED_TRACE(mpc ? "MPC" : "PD");
    DiagramBuilder builder;
    auto& loop = builder.Add<CdprLoop>("loop", Circle(robot, mpc));
    Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-4, .atol = 1e-6});
    const auto log = simulator.AddLog(Hz(100), {&loop.command, &loop.cables});
    const RunStatus status = simulator.AdvanceTo(1.5);
    ASSERT_FALSE(status.ended) << status.reason;
    const Vec<3> should = simulator.context().Eval(loop.reference.reference).position;
    EXPECT_THAT(simulator.context().Eval(loop.platform).p_WB, IsNear(should, 0.01));
    EXPECT_GT((should - Vec<3>(0.1, 0, 2)).norm(), 0.1);  // the platform has moved
    if (mpc) {
      EXPECT_EQ(simulator.context().Eval(loop.control.mpc->diagnostics).fallbacks, 0);
    }
    const std::string last = std::to_string(GetParam() - 1);
    EXPECT_THAT(log->column("loop.command." + last),
                ::testing::Each(::testing::AllOf(::testing::Ge(1), ::testing::Le(800))));
    EXPECT_THAT(log->column("loop.cables.tension." + last), ::testing::Each(::testing::Gt(0)));
  }
}

TEST_P(ManyCables, RunWithoutAllocating) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  const CdprDescription robot = RobotFromFile(GetParam());
  for (const bool mpc : {false, true}) {
    DiagramBuilder builder;
    builder.Add<CdprLoop>("loop", Circle(robot, mpc));
    Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-4, .atol = 1e-6});
    simulator.RunTo(0.02);
    EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.04); }), 0) << (mpc ? "MPC" : "PD");
  }
}

// Three cables, and planar robots with two and four in a vertical circle. A gust out of the plane makes these
// swing, and the controllers remain calm.
TEST(FewCables, FollowTheCircleUnderPdAndMpc) {
  const Vec<3> x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  for (const CdprDescription& robot : {test::ThreeCableRobot(), test::PlanarRobot(2), test::PlanarRobot(4)}) {
    const bool planar = PlaneOf(robot).has_value();
    const auto path =
        std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.3, 12, 2, x, planar ? z : y));
    for (const bool mpc : {false, true}) {
      SCOPED_TRACE(robot.name + std::to_string(robot.num_cables()) + (mpc ? ", MPC" : ", PD"));
      CdprLoopParams params = mpc ? test::WithMpc(robot, path) : test::WithPd(robot, path);
      if (mpc) params.offset_free = true;
      params.forbid_slack = false;
      if (planar) params.gusts.gusts.push_back({{0, 3, 0}, 1, 0.5});
      DiagramBuilder builder;
      auto& loop = builder.Add<CdprLoop>("loop", params);
      Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-4, .atol = 1e-6});
      const auto log = simulator.AddLog(Hz(50), {&loop.platform, &loop.reference.reference});
      const RunStatus status = simulator.AdvanceTo(6);
      ASSERT_FALSE(status.ended) << status.reason;
      const Vec<3> away = simulator.context().Eval(loop.platform).p_WB -
                          simulator.context().Eval(loop.reference.reference).position;
      EXPECT_LT(std::abs(away[0]) + std::abs(away[2]), mpc ? 0.005 : 0.02);
      EXPECT_LT(std::abs(away[1]), planar ? 0.1 : 0.01);
      if (mpc) {
        EXPECT_EQ(simulator.context().Eval(loop.control.mpc->diagnostics).fallbacks, 0);
      }
    }
  }
}

// Cables in one point, at the CoM and above it, and a platform on a table, which a gust cannot lift or tilt.
TEST(FewCables, FollowTheCircleInOnePointAndOnATable) {
  for (const CdprDescription& robot :
       {test::OnePointRobot(4, 0), test::OnePointRobot(4, 0.1), test::TableRobot()}) {
    const auto path =
        std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, robot.on_table ? 1 : 2}, 0.3, 12, 2));
    for (const bool mpc : {false, true}) {
      SCOPED_TRACE(robot.name + (mpc ? ", MPC" : ", PD"));
      CdprLoopParams params = mpc ? test::WithMpc(robot, path) : test::WithPd(robot, path);
      if (mpc) params.offset_free = true;
      params.forbid_slack = false;
      if (robot.on_table) params.gusts.gusts.push_back({{1, 0, 50}, 1, 0.5});
      DiagramBuilder builder;
      auto& loop = builder.Add<CdprLoop>("loop", params);
      Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-4, .atol = 1e-6});
      const RunStatus status = simulator.AdvanceTo(6);
      ASSERT_FALSE(status.ended) << status.reason;
      const PlatformState platform = simulator.context().Eval(loop.platform);
      const CdprReference reference = simulator.context().Eval(loop.reference.reference);
      const Vec<3> euler = EulerFromRotation(platform.R_WB());
      EXPECT_LT((platform.p_WB - reference.position).norm(), mpc ? 0.005 : 0.03);
      EXPECT_LT(euler.head<2>().norm(), 0.05);
      if (robot.on_table) EXPECT_EQ(Vec<3>(euler[0], euler[1], platform.p_WB[2]), Vec<3>(0, 0, 1));
      if (mpc) EXPECT_EQ(simulator.context().Eval(loop.control.mpc->diagnostics).fallbacks, 0);
    }
  }
}

// The platform holds its place while every anchor moves, and on springs. Controllers that do not know of
// these err much more.
TEST(MovingAnchorsAndSprings, AreFollowedUnderPdAndMpcWithoutAllocating) {
  const CdprDescription standing = test::FourCableRobot();
  const auto error = [&](const CdprDescription& robot, const CdprDescription& believed, bool mpc) {
    const auto path = std::make_shared<EquilibriumPath>(believed, Path::Hold({0, 0, 2}));
    CdprLoopParams params = mpc ? test::WithMpc(believed, path) : test::WithPd(believed, path);
    params.robot = robot;
    params.offset_free = mpc;
    params.forbid_slack = false;
    DiagramBuilder builder;
    auto& loop = builder.Add<CdprLoop>("loop", params);
    Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-4, .atol = 1e-6});
    simulator.RunTo(0.3);
    EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.35); }), 0) << (mpc ? "MPC" : "PD");
    double worst = 0;
    while (simulator.context().time() < 1.5) {
      simulator.RunTo(simulator.context().time() + 0.05);
      worst = std::max(worst, (simulator.context().Eval(loop.platform).p_WB - Vec<3>(0, 0, 2)).norm());
    }
    return worst;
  };
  const CdprDescription moving = test::WithMovingAnchors(standing), sprung = test::WithSprings(standing);
  EXPECT_LT(error(moving, moving, true), 0.01);
  EXPECT_LT(error(moving, moving, false), 0.04);
  EXPECT_GT(error(moving, standing, true), 0.03);
  EXPECT_GT(error(moving, standing, false), 0.06);
  for (const bool mpc : {false, true}) {
    EXPECT_LT(error(sprung, sprung, mpc), 1.1 * error(standing, standing, mpc) + 1e-12);
    EXPECT_GT(error(sprung, standing, mpc), 0.03);
  }
}

}  // namespace tenon::many_cables_test
