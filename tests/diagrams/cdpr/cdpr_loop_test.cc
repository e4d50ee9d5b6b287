#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cdpr_loop_test {

constexpr SimulatorOptions kOptions{.order = 2, .rtol = 1e-5, .atol = 1e-7};

/// The loop in a diagram of its own.
struct Cell {
  explicit Cell(const CdprLoopParams& params)
      : loop(builder.Add<CdprLoop>("loop", params)), diagram(builder.Build()) {}
  DiagramBuilder builder;
  CdprLoop& loop;
  std::shared_ptr<const Diagram> diagram;
};

TEST(CdprLoopTest, FollowsTheCircleWithTautCables) {
  const Cell cell(test::CircleWithPd());
  Simulator simulator(*cell.diagram, kOptions);
  const auto log = simulator.AddLog(Hz(100), {&cell.loop.world.plant.platform, &cell.loop.reference.reference,
                                              &cell.loop.command, &cell.loop.world.plant.cables});
  EXPECT_FALSE(simulator.AdvanceTo(12).ended);
  for (const char* axis : {"x", "y", "z"}) {
    const std::vector<double> is = log->column(std::string("loop.plant.platform.p_WB.") + axis);
    const std::vector<double> should = log->column(std::string("loop.reference.reference.position.") + axis);
    for (std::size_t i = 0; i < is.size(); ++i)
      ASSERT_NEAR(is[i], should[i], 0.05) << axis << " in row " << i;
  }
  for (const char* cable : {"0", "1", "2", "3"}) {
    EXPECT_THAT(log->column(std::string("loop.command.") + cable),
                ::testing::Each(::testing::AllOf(::testing::Ge(0), ::testing::Le(800))));
    EXPECT_THAT(log->column(std::string("loop.plant.cables.tension.") + cable),
                ::testing::Each(::testing::Gt(0)));
  }
}

TEST(CdprLoopTest, RefusesKnownAdditionsWithoutALoad) {
  CdprLoopParams params = test::CircleWithPd();
  params.known_additions = true;
  EXPECT_TRUE(Throws<ParameterError>([&] { CdprLoop loop(params); }, "known_additions", "feedforward"));
  params.feedforward = true;
  EXPECT_NE(CdprLoop(params).observer.controller_load, nullptr);
}

TEST(CdprLoopTest, RefusesAStartAtAnAnchor) {
  CdprLoopParams params = test::CircleWithPd();
  const CdprReference at = params.path->At(0);
  const CableDescription& cable = params.robot.cables[1];
  params.start_turn = -at.euler;
  params.start_offset = cable.anchor_W - cable.attachment_B - at.position;
  EXPECT_TRUE(Throws<ParameterError>([&] { CdprLoop loop(params); }, "Cable 1 of 'cdpr_4'"));
}

// With locked winches the plant stays at the equilibrium of the solver.
TEST(CdprLoopTest, PlantRestsAtTheEquilibriumOfTheSolver) {
  const CdprDescription robot = test::ShippedFourCableRobot();
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 2), Eigen::Vector3d(0.8, -1.1, 1.6)}) {
    const StaticEquilibrium rest = SolveInverseGeometricoStatic(robot, p);
    const CdprPlantParams params{.robot = robot,
                                 .p_WB = rest.p_WB,
                                 .euler = rest.euler,
                                 .initial_tension = rest.tension,
                                 .lock_winches = true};
    DiagramBuilder builder;
    auto& plant = builder.Add<CdprPlant>("plant", params);
    const CableVector tension = rest.tension;
    auto& hold = builder.AddFunction("hold", Uses(builder.time), [tension](double) { return tension; });
    builder.Connect(hold, plant.command);
    Simulator simulator(builder.Build(), {.order = 5, .rtol = 1e-9, .atol = 1e-12});
    for (int second = 1; second <= 10; ++second) {
      simulator.RunTo(second);
      ASSERT_THAT(simulator.context().Eval(plant.platform).p_WB, IsNear(p, 1e-6))
          << "at t = " << second << " s";
    }
  }
}

TEST(CdprLoopTest, SlackCableEndsTheRun) {
  CdprLoopParams params = test::CircleWithPd();
  params.payload.payload = {12, {0.3, 0.3, 0.5}};
  params.payload.attach_s = 0.1;
  params.payload.release_s = 0.4;
  params.pd_stiffness_N_per_m = 20000;
  params.pd_damping_N_s_per_m = 10;
  const Cell cell(params);
  Simulator simulator(*cell.diagram, kOptions);
  const RunStatus status = simulator.AdvanceTo(10);
  EXPECT_TRUE(status.ended);
  EXPECT_THAT(status.reason, ::testing::HasSubstr("loop.monitor.tension: cable"));
}

}  // namespace tenon::cdpr_loop_test
