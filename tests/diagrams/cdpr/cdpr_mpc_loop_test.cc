// The cable robot under its MPC, with the estimator in the loop.

#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/testing/matchers.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>

namespace tenon::cdpr_mpc_loop_test {
namespace {

constexpr SimulatorOptions kOptions{.order = 2, .rtol = 1e-3, .atol = 1e-5};

CdprLoopParams WithMpc(const CdprDescription& robot, std::shared_ptr<const EquilibriumPath> path) {
  CdprLoopParams params;
  params.robot = robot;
  params.path = path;
  params.mpc.emplace();
  params.mpc->path = path;
  params.mpc->horizon = 1.2;
  params.mpc->num_steps = 25;
  params.mpc->weights = {
      .position = 1000, .velocity = 20, .attitude = 20, .angular_velocity = 1, .tension = 3e-3};
  params.offset_free = false;
  params.forbid_slack = false;
  return params;
}

/// The loop in a diagram of its own, run to `end`.
struct Flight {
  Flight(const CdprLoopParams& params, double end)
      : loop(builder.Add<CdprLoop>("loop", params)),
        diagram(builder.Build()),
        simulator(*diagram, kOptions),
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

// From the middle of a circle; the PD follows the same reference.
TEST(CdprMpcLoop, FollowsAGoalThatComesAsItFlies) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  const auto path = std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.5, 10, 2));
  CdprLoopParams pd = WithMpc(robot, path);
  pd.mpc.reset();
  pd.pd_stiffness_N_per_m = 2000;
  pd.pd_damping_N_s_per_m = 200;
  for (const CdprLoopParams& params : {WithMpc(robot, path), pd}) {
    DiagramBuilder builder;
    auto& loop = builder.Add<CdprLoop>("loop", params);
    auto& goal = builder.Add<GoalPath>("goal", GoalPathParams{path});
    builder.Connect(goal.path, loop.reference.path);
    if (loop.control.mpc != nullptr) builder.Connect(goal.path, loop.control.mpc->path);
    const auto diagram = builder.Build();
    Simulator simulator(*diagram, kOptions);
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
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto ball = [&](double radius) {
    Eigen::Vector3d v;
    do v = {uniform(generator), uniform(generator), uniform(generator)};
    while (v.norm() > 1);
    return Eigen::Vector3d(radius * v);
  };
  for (int i = 0; i < 200; ++i) {
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
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  CdprDescription believed = robot;
  believed.mass *= 1.1;
  Flight run(WithMpc(robot, std::make_shared<EquilibriumPath>(believed, Path::Circle({0, 0, 2}, 0.5, 10, 2))),
             10);
  EXPECT_FALSE(run.status.ended);
  EXPECT_GT(run.Error(), 0.005);  // the weight that is not there
  EXPECT_LT(run.Error(), 0.05);
}

// All but the wall-clock time that the solves took.
TEST(CdprMpcLoop, RestoredRunGoesOnBitForBit) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  Flight run(WithMpc(robot, std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.5, 10, 2))),
             0.333);
  auto context = run.diagram->CreateContext();
  context->Restore(run.simulator.context().Save());
  Simulator restored(std::move(context), kOptions);
  restored.RunTo(0.7);
  Simulator fresh(*run.diagram, kOptions);
  fresh.RunTo(0.7);
  const PlatformState a = restored.context().Eval(run.loop.world.plant.platform);
  const PlatformState b = fresh.context().Eval(run.loop.world.plant.platform);
  EXPECT_THAT(a.p_WB, IsNear(b.p_WB, 0));
  EXPECT_THAT(a.q_WB, IsNear(b.q_WB, 0));
  EXPECT_THAT(restored.context().Eval(run.loop.command), IsNear(fresh.context().Eval(run.loop.command), 0));
}

// One diagram, two threads with a context each: the numbers of one thread.
TEST(CdprMpcLoop, ThreadsGiveTheNumbersOfOne) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  const Flight alone(
      WithMpc(robot, std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.5, 10, 2))), 0.5);
  const auto run = [&](Eigen::VectorXd* end) {
    Simulator simulator(*alone.diagram, kOptions);
    simulator.RunTo(0.5);
    *end = simulator.context().continuous_state();
  };
  Eigen::VectorXd first, second;
  std::thread one(run, &first), two(run, &second);
  one.join();
  two.join();
  EXPECT_EQ(first, alone.simulator.context().continuous_state());
  EXPECT_EQ(second, alone.simulator.context().continuous_state());
}

}  // namespace
}  // namespace tenon::cdpr_mpc_loop_test
