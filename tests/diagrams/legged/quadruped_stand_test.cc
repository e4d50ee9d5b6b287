#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::quadruped_stand_test {

using test::A1, test::DogBot;

QuadrupedStandParams Params(const QuadrupedDescription& robot) {
  QuadrupedStandParams params;
  params.world.plant.robot = robot;
  params.world.plant.initial = test::Standing(robot);
  params.pd = {.robot = robot, .stiffness = 500, .damping = 10};
  params.world.min_height = 0.5 * robot.StanceHeight();
  return params;
}

/// The loop in its own diagram.
struct Cell {
  explicit Cell(const QuadrupedStandParams& params)
      : loop(builder.Add<QuadrupedStand>("loop", params)),
        diagram(builder.Build()),
        simulator(*diagram, RecommendedOptions(loop)) {}
  template <class S>
  const typename S::Value& operator[](const S& source) {
    return simulator.context().Eval(source);
  }
  DiagramBuilder builder;
  QuadrupedStand& loop;
  std::shared_ptr<const Diagram> diagram;
  Simulator simulator;
};

// With the feed-forward of gravity the joints keep the stance, except for friction and the compression of the
// feet. Without it they sag by tau / K_p.
TEST(QuadrupedStandTest, GravityCompensationHoldsTheStance) {
  for (const QuadrupedDescription& robot : {DogBot(), A1()}) {
    QuadrupedStandParams params = Params(robot);
    Cell with(params);
    EXPECT_FALSE(with.simulator.AdvanceTo(2).ended);
    const double friction = robot.drive.friction / 500;
    EXPECT_THAT(with[with.loop.world.state].q, IsNear(robot.stance, friction + 5e-4)) << robot.name;
    params.pd.gravity_compensation = false;
    Cell without(params);
    EXPECT_FALSE(without.simulator.AdvanceTo(2).ended);
    EXPECT_GT((without[without.loop.world.state].q - robot.stance).cwiseAbs().maxCoeff(), friction + 5e-3);
  }
}

TEST(QuadrupedStandTest, LandsFromADropAndStands) {
  QuadrupedStandParams params = Params(DogBot());
  params.world.plant.initial.p_WB[2] += 0.1;
  Cell cell(params);
  EXPECT_FALSE(cell.simulator.AdvanceTo(2).ended);
  EXPECT_NEAR(cell[cell.loop.world.state].p_WB[2], DogBot().StanceHeight(), 5e-3);
  EXPECT_LT(cell[cell.loop.world.state].v_W.norm(), 1e-3);
}

TEST(QuadrupedStandTest, FallsWhenPushedOver) {
  QuadrupedStandParams params = Params(DogBot());
  params.world.pulses = {{.push = {.force_W = {0, 400, 0}}, .start = 0.5, .duration = 1}};
  Cell cell(params);
  const RunStatus status = cell.simulator.AdvanceTo(4);
  EXPECT_TRUE(status.ended);
  EXPECT_GT(status.time, 0.5);
  EXPECT_THAT(status.reason, ::testing::HasSubstr("loop.world.monitor.fall: "));
}

// The feet carry the weights of robot and payload and the vertical external force.
TEST(QuadrupedStandTest, FeetCarryPayloadAndDisturbances) {
  QuadrupedStandParams params = Params(DogBot());
  params.world.plant.payload.mass = 10;
  params.world.plant.payload.com = {0, 0, 0.1};
  params.world.pulses = {{.push = {.force_W = {0, 0, -30}}, .duration = 10}};
  params.world.sines = {{.amplitude = {.force_W = {0, 0, -20}}, .end = 1}};
  params.world.random = {{DogBot(), true, 0, 1e-9}};
  Cell cell(params);
  EXPECT_FALSE(cell.simulator.AdvanceTo(3).ended);
  double carried = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) carried += cell[cell.loop.world.foot_sensor.measured][leg][2];
  EXPECT_NEAR(carried, (DogBot().mass() + 10) * 9.81 + 30, 0.1);
  // At rest the IMU measures gravity, and the torque sensors the commanded torques.
  EXPECT_NEAR(cell[cell.loop.world.imu.measurement].specific_force_B.norm(), 9.81, 0.3);
  EXPECT_THAT(cell[cell.loop.world.torque_sensor.measured], IsNear(cell[cell.loop.pd.torque], 1e-12));
}

// Walks whose reference of the CoM is the ZMP spline.
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

}  // namespace tenon::quadruped_stand_test
