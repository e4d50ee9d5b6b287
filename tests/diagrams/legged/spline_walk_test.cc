// Walks whose reference of the CoM is the ZMP spline.

#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>

#include <gtest/gtest.h>

namespace tenon::spline_walk_test {

class SplineWalkTest : public ::testing::TestWithParam<Gait> {};
INSTANTIATE_TEST_SUITE_P(Gaits, SplineWalkTest,
                         ::testing::Values(Gait::kCrawl, Gait::kTrot, Gait::kPace, Gait::kGallop),
                         [](const auto& info) { return std::string(EnumName(info.param)); });

TEST_P(SplineWalkTest, ThePlantFollows) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.locomotion.com_planner.reference = ComReference::kZmpSpline;
  params.walk.segments = {{.duration = 0.5},
                          {.gait = GetParam(), .forward = 0.12, .yaw_rate = 0.05, .duration = 3},
                          {.duration = 1}};
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), test::TrotLoop::Options());
  double com = 0;
  for (int n = 1; n <= 4500; ++n) {
    const RunStatus status = simulator.AdvanceTo(n / 1000.0);
    ASSERT_FALSE(status.ended) << status.reason;
    com = std::max(com, simulator.context().Eval(loop.errors.errors).com.norm());
  }
  EXPECT_LT(com, 5e-3);
  const ComDiagnostics& diagnostics = simulator.context().Eval(loop.locomotion.com_planner.diagnostics);
  EXPECT_GT(diagnostics.solves, 10);
  EXPECT_EQ(diagnostics.failures, 0);
  const LeggedState& end = simulator.context().Eval(loop.world.plant.state);
  EXPECT_GT(end.p_WB[0], 0.3);
  EXPECT_LT(end.v_W.norm(), 0.01);
}

// The planner of the thesis resets its reference to the robot, so the robot is compared with the commanded
// path, from which the stop in each stance displaces it by at most a step.
TEST(ThesisSplineWalkTest, ThePlantFollowsTheCommandedPath) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.locomotion.com_planner.reference = ComReference::kThesis;
  params.walk.segments = {{.duration = 0.5},
                          {.gait = Gait::kTrot, .forward = 0.12, .yaw_rate = 0.05, .duration = 3},
                          {.duration = 1}};
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, test::TrotLoop::Options());
  double away = 0;
  for (int n = 1; n <= 4500; ++n) {
    const RunStatus status = simulator.AdvanceTo(n / 1000.0);
    ASSERT_FALSE(status.ended) << status.reason;
    const Vec<2> com = simulator.context().Eval(loop.errors.errors).com_position.head<2>();
    away =
        std::max(away, (com - simulator.context().Eval(loop.locomotion.com_planner.path).position_W).norm());
  }
  EXPECT_LT(away, 0.12 * 0.265);
  const ComDiagnostics& diagnostics = simulator.context().Eval(loop.locomotion.com_planner.diagnostics);
  EXPECT_GT(diagnostics.solves, 10);
  EXPECT_EQ(diagnostics.failures, 0);
  EXPECT_LT(simulator.context().Eval(loop.world.plant.state).v_W.norm(), 0.01);
}

}  // namespace tenon::spline_walk_test
