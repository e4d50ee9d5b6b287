// The cable robot under its MPC, with the estimator in the loop.

#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/testing/block_test.h>

#include <random>

namespace tenon::cdpr_mpc_loop_test {

using test::WithMpc;

constexpr SimulatorOptions kOptions{.order = 2, .rtol = 1e-3, .atol = 1e-5};

/// The loop in a diagram of its own, run to `end`.
struct Flight {
  Flight(const CdprLoopParams& params, double end, const SimulatorOptions& options = kOptions)
      : loop(builder.Add<CdprLoop>("loop", params)),
        diagram(builder.Build()),
        simulator(*diagram, options),
        log(simulator.AddLog(Hz(200),
                             {&loop.world.plant.platform, &loop.reference.reference, &loop.command})),
        status(simulator.AdvanceTo(end)) {}
  double Error() {
    return (simulator.context().Eval(loop.world.plant.platform).p_WB -
            simulator.context().Eval(loop.reference.reference).position)
        .norm();
  }
  DiagramBuilder builder;
  CdprLoop& loop;
  std::shared_ptr<const Diagram> diagram;
  Simulator simulator;
  std::shared_ptr<MemoryLog> log;
  RunStatus status;
};

// The circle of D1 with the apps' options, against CVODE's Adams-Moulton method of order 12 at 1e-12, which
// shares neither steps nor coefficients with the Runge-Kutta method of the options.
TEST(CdprMpcLoop, AnotherIntegratorGivesTheSameFlight) {
  const CdprLoopParams params =
      WithMpc(test::ShippedFourCableRobot(), test::CirclePath(test::ShippedFourCableRobot()));
  Flight usual(params, 2, CdprIntegration().Options());
  SimulatorOptions exact = CdprIntegration().Options();
  exact.method = Method::kAdams;
  exact.order = 12;
  exact.rtol = 1e-12;
  exact.atol = 1e-14;
  Flight adams(params, 2, exact);
  EXPECT_THAT(usual.simulator.context().Eval(usual.loop.world.plant.platform).p_WB,
              IsNear(adams.simulator.context().Eval(adams.loop.world.plant.platform).p_WB, 3e-6));
  EXPECT_GT(adams.simulator.statistics().evaluations, 10 * usual.simulator.statistics().evaluations);
}

// The goal arrives in the middle of a circle. The PD controller follows the reference too.
TEST(CdprMpcLoop, FollowsAGoalThatIsSetInFlight) {
  const CdprDescription robot = test::ShippedFourCableRobot();
  const auto path = test::CirclePath(robot);
  CdprLoopParams pd = test::WithPd(robot, path);
  pd.offset_free = pd.forbid_slack = false;
  for (const CdprLoopParams& params : {WithMpc(robot, path), pd}) {
    DiagramBuilder builder;
    auto& loop = builder.Add<CdprLoop>("loop", params);
    auto& goal = builder.Add<GoalPath>("goal", GoalPathParams{path});
    builder.Connect(goal.path, loop.reference.path);
    if (loop.control.mpc != nullptr) builder.Connect(goal.path, loop.control.mpc->path);
    Simulator simulator(builder.Build(), kOptions);
    simulator.RunTo(3);
    Context& context = simulator.context();
    const Vec<3> place(0.2, -0.4, 2.2);
    context.Set(goal.goal, goal.GoalAt(place, context.time(), context.Eval(loop.reference.reference)));
    double worst = 0;
    while (context.time() < 8) {
      ASSERT_FALSE(simulator.AdvanceTo(context.time() + 0.05).ended);
      worst = std::max(worst, (context.Eval(loop.world.plant.platform).p_WB -
                               context.Eval(loop.reference.reference).position)
                                  .norm());
    }
    EXPECT_LT(worst, loop.control.mpc != nullptr ? 0.01 : 0.05);
    EXPECT_THAT(context.Eval(loop.world.plant.platform).p_WB,
                IsNear(place, loop.control.mpc != nullptr ? 0.01 : 0.04));
  }
}

TEST(CdprMpcLoop, ReachesTheReferenceFromRandomStarts) {
  const CdprDescription robot = test::ShippedFourCableRobot();
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto ball = [&](double radius) {
    Eigen::Vector3d v;
    do v = {uniform(generator), uniform(generator), uniform(generator)};
    while (v.norm() > 1);
    return Eigen::Vector3d(radius * v);
  };
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d goal(1.2 * uniform(generator), 1.6 * uniform(generator),
                               2 + 0.6 * uniform(generator));
    CdprLoopParams params = WithMpc(robot, std::make_shared<EquilibriumPath>(robot, Path::Hold(goal)));
    params.start_offset = ball(1);
    params.start_turn = ball(0.3);
    Flight run(params, 6);
    ASSERT_FALSE(run.status.ended) << i << ": " << run.status.reason;
    ASSERT_LT(run.Error(), 0.02) << i << " from " << params.start_offset.transpose() << " to "
                                 << goal.transpose();
    ASSERT_EQ(run.simulator.context().Eval(run.loop.control.mpc->diagnostics).fallbacks, 0) << i;
    for (const char* cable : {"0", "1", "2", "3"}) {
      ASSERT_THAT(run.log->column(std::string("loop.command.") + cable),
                  ::testing::Each(::testing::AllOf(::testing::Ge(0), ::testing::Le(800))));
    }
  }
}

TEST(CdprMpcLoop, FollowsTheCircleWithAWrongMass) {
  const CdprDescription robot = test::ShippedFourCableRobot();
  CdprDescription believed = robot;
  believed.mass *= 1.1;
  Flight run(WithMpc(robot, test::CirclePath(believed)), 10);
  EXPECT_FALSE(run.status.ended);
  EXPECT_GT(run.Error(), 0.005);  // due to the wrong weight
  EXPECT_LT(run.Error(), 0.05);
}

}  // namespace tenon::cdpr_mpc_loop_test
