// The planner of section 2.4.1 behind a made-up schedule, without a plant: every plan begins at the measured
// motion and rests at its end.

#include <tenon/controllers/legged/planning/thesis_planner.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::thesis_planner_test {

const PlanarPoint kBegin{{0.1, -0.2}, {0.3, 0.05}, {-0.7, 1.1}};

TEST(ThesisPlannerPolynomials, KeepTheirBoundaryConditions) {
  const PlanarPoint end{{0.4, 0.1}, {-0.2, 0.15}, {0.6, -0.9}};
  const double T = 0.37;
  const PlanarSpline quintic = QuinticBetween(kBegin, end, T);
  for (const auto& [t, point] : {std::pair{0.0, kBegin}, {T, end}}) {
    EXPECT_THAT(quintic.At(t).position, IsNear(point.position, 1e-14));
    EXPECT_THAT(quintic.At(t).velocity, IsNear(point.velocity, 1e-13));
    EXPECT_THAT(quintic.At(t).acceleration, IsNear(point.acceleration, 1e-11));
  }
  const PlanarSpline cubic = CubicToRest(kBegin, end.position, T);
  EXPECT_THAT(cubic.At(0).position, IsNear(kBegin.position, 1e-14));
  EXPECT_THAT(cubic.At(0).velocity, IsNear(kBegin.velocity, 1e-13));
  EXPECT_THAT(cubic.At(T).position, IsNear(end.position, 1e-14));
  EXPECT_THAT(cubic.At(T).velocity, IsNear(Vec<2>(0, 0), 1e-13));
  // The third derivative of a cubic is constant: its acceleration is linear.
  EXPECT_THAT(Vec<2>(cubic.At(0).acceleration + cubic.At(T).acceleration),
              IsNear(Vec<2>(2 * cubic.At(T / 2).acceleration), 1e-11));
}

class ThesisPlannerTest : public ::testing::Test {
 protected:
  ThesisPlannerTest() {
    state_ = test::Standing(robot_);
    state_.p_WB += Vec<3>(0.004, -0.003, 0.002);
    state_.v_W << 0.02, 0.01, -0.03;
    state_.w_W << 0.1, -0.05, 0.02;
    state_.q_WB = QuaternionFromEuler({0.02, -0.03, 0.01});
    QuadrupedModel(robot_).Calc(state_, &dynamics_);
    schedule_.gait = Gait::kTrot;
    schedule_.timing.num_steps = 2;
    schedule_.timing.step = {0, 1, 1, 0};
    schedule_.timing.stance = 0.15;
    schedule_.timing.swing = 0.115;
    schedule_.footsteps = 1;
    command_.gait = Gait::kTrot;
    command_.forward = 0.12;
    const double weight = robot_.mass() * kGravity;
    for (int leg = 0; leg < kNumLegs; ++leg) forces_[leg] << 0.5, -0.2, weight / 4;
    rig_.Fix(block_.schedule, schedule_).Fix(block_.command, command_).Fix(block_.ground, GroundPlane());
    rig_.Fix(block_.state, state_).Fix(block_.foot_forces, forces_);
  }
  /// Two feet lift off at the end of the stance.
  BodyReference LiftOff() {
    At(0.149);
    schedule_.legs[kFrontLeft].state = schedule_.legs[kRearRight].state = ContactState::kSwing;
    rig_.Fix(block_.schedule, schedule_);
    return At(0.15);
  }
  BodyReference At(double time) { return rig_.RunTo(time)[block_.reference]; }

  QuadrupedDescription robot_ = test::DogBot();
  LeggedState state_;
  QuadrupedDynamics dynamics_;
  ContactSchedule schedule_;
  WalkCommand command_;
  FootForces forces_;
  TestRig<ThesisPlanner> rig_{ComPlannerParams{.robot = robot_}};
  const ThesisPlanner& block_ = rig_.system();
};

TEST_F(ThesisPlannerTest, AStanceGoesFromTheMeasuredMotionToTheCentreOfTheFeetAtRest) {
  const BodyReference begin = At(0);
  EXPECT_THAT(begin.com_W, IsNear(dynamics_.com_W, 1e-12));
  EXPECT_THAT(begin.com_velocity_W, IsNear(dynamics_.com_velocity_W, 1e-12));
  EXPECT_THAT(EulerFromRotation(RotationFromQuaternion(begin.q_WB)),
              IsNear(Vec<3>(0.02, -0.03, 0.01), 1e-12));
  EXPECT_THAT(begin.w_W, IsNear(state_.w_W, 1e-12));
  const BodyReference end = At(0.15);
  // The pair of the trot's feet that swings next is half a stance ahead of its lift-off, the other one a step
  // less.
  const double stance = 2 * 0.265 - 0.115, ahead = (0.15 + 0.15 + 0.265 - stance) / 2 * 0.12;
  const Vec<2> start = rig_.system().stance.center_B;
  EXPECT_THAT(Vec<2>(end.com_W.head<2>()), IsNear(Vec<2>(start + Vec<2>(ahead, 0)), 1e-12));
  EXPECT_NEAR(end.com_W[2], block_.stance.com_height, 1e-12);
  EXPECT_THAT(end.com_velocity_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_THAT(end.q_WB, IsNear(Vec<4>(1, 0, 0, 0), 1e-12)) << "level, along the path";
  EXPECT_THAT(end.w_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_THAT(At(0.2).com_W, IsNear(end.com_W, 1e-12)) << "rests if the feet lift off late";
}

TEST_F(ThesisPlannerTest, ASwingContinuesTheMeasuredAccelerationAndEndsAtRestWithItsZmpInThePolygons) {
  const BodyReference begin = LiftOff();
  const ThesisPlan plan = rig_[block_.plan];
  EXPECT_EQ(plan.diagnostics.solves, 1);
  ASSERT_EQ(plan.diagnostics.failures, 0);
  EXPECT_THAT(begin.com_W, IsNear(dynamics_.com_W, 1e-12));
  EXPECT_THAT(begin.com_velocity_W, IsNear(dynamics_.com_velocity_W, 1e-12));
  EXPECT_THAT(Vec<2>(begin.com_acceleration_W.head<2>()),
              IsNear(Vec<2>(Vec<2>(2, -0.8) / robot_.mass()), 1e-9));
  EXPECT_NEAR(plan.spline.duration, 2 * 0.265, 1e-12) << "two swings and stances";
  const PlanarPoint end = plan.spline.At(plan.spline.duration);
  EXPECT_THAT(end.velocity, IsNear(Vec<2>(0, 0), 1e-9));
  EXPECT_LT((end.position - block_.stance.center_B - Vec<2>(2 * 0.265 * 0.12, 0)).norm(), 0.02);
  // Position, velocity and acceleration are continuous where the polynomials meet.
  double t = 0;
  for (int k = 0; k + 1 < plan.spline.num_segments; ++k) {
    t += plan.spline.segments[static_cast<std::size_t>(k)].duration;
    const PlanarPoint before = plan.spline.At(t - 1e-9), after = plan.spline.At(t + 1e-9);
    EXPECT_THAT(after.position, IsNear(before.position, 1e-8));
    EXPECT_THAT(after.velocity, IsNear(before.velocity, 1e-7));
    EXPECT_THAT(after.acceleration, IsNear(before.acceleration, 1e-5));
  }
  // Within the swing: the rectangle of the two stance feet, half as wide as 2 half_width, and its margin.
  const Vec<2> left = block_.stance.foot[kRearLeft], right = block_.stance.foot[kFrontRight];
  const Vec<2> along = (right - left).normalized();
  for (double s = 0.02; s <= 0.115; s += 0.115 / 6) {
    const PlanarPoint x = plan.spline.At(s);
    const Vec<2> zmp = x.position - block_.stance.com_height / 9.81 * x.acceleration - block_.stance.center_B;
    const Vec<2> across(zmp - along * along.dot(zmp));
    EXPECT_LT(across.norm(), ZmpPlanParams().half_width + 0.01) << s;
  }
}

// 40 N of the four feet put the ZMP 0.08 m from the line of the two that stay: the spline begins with the ZMP
// at the edge.
TEST_F(ThesisPlannerTest, ASwingBeginsWithAnAccelerationThatItsFeetCanExert) {
  for (int leg = 0; leg < kNumLegs; ++leg) forces_[leg][1] = 10;
  rig_.Fix(block_.foot_forces, forces_);
  const BodyReference begin = LiftOff();
  const Vec<2> zmp =
      begin.com_W.head<2>() - block_.stance.com_height / 9.81 * begin.com_acceleration_W.head<2>();
  const Vec<2> along = (block_.stance.foot[kFrontRight] - block_.stance.foot[kRearLeft]).normalized();
  const Vec<2> from_line = zmp - block_.stance.center_B;
  EXPECT_NEAR((from_line - along * along.dot(from_line)).norm(),
              ZmpPlanParams().half_width - ZmpPlanParams().margin, 4e-3)
      << "up to the way of the path within a step";
  EXPECT_EQ(rig_[block_.diagnostics].failures, 0);
}

TEST_F(ThesisPlannerTest, WithoutASplineThePlanIsTheRegularisedPath) {
  state_.p_WB[1] += 0.5;  // far outside of the support
  QuadrupedModel(robot_).Calc(state_, &dynamics_);
  rig_.Fix(block_.state, state_);
  LiftOff();
  const ThesisPlan plan = rig_[block_.plan];
  EXPECT_EQ(plan.diagnostics.failures, 1);
  EXPECT_EQ(plan.spline.num_segments, 1);
  EXPECT_THAT(plan.spline.At(0).position, IsNear(Vec<2>(dynamics_.com_W.head<2>()), 1e-12));
  const PlanarPoint end = plan.spline.At(plan.spline.duration);
  EXPECT_THAT(end.velocity, IsNear(Vec<2>(0, 0), 1e-9));
  EXPECT_THAT(end.acceleration, IsNear(Vec<2>(0, 0), 1e-8));
}

// At the end of the stance, weight and push have no horizontal moment about the centre of the feet that stay.
TEST_F(ThesisPlannerTest, AHeuristicPlanRestsWhereTheFeetThatStayHoldThePush) {
  TestRig<ThesisPlanner> rig({.robot = robot_, .reference = ComReference::kHeuristic});
  const ThesisPlanner& block = rig.system();
  schedule_.timing.num_steps = 4;
  schedule_.timing.step = {0, 1, 2, 3};
  command_.forward = 0;
  const WrenchEstimate push{.force_W = {20, -15, 30}, .torque_W = {2, -3, 1}};
  rig.Fix(block.schedule, schedule_).Fix(block.command, command_).Fix(block.ground, GroundPlane());
  rig.Fix(block.state, state_).Fix(block.foot_forces, forces_).Fix(block.wrench, push);
  const Vec<3> com = rig.RunTo(0.15)[block.reference].com_W;
  Vec<3> arm = com;
  arm.head<2>() -= block.stance.center_B - block.stance.foot[kFrontLeft] / 3;
  const Vec<3> down(0, 0, -robot_.mass() * kGravity);
  EXPECT_LT((arm.cross(Vec<3>(push.force_W + down)) + push.torque_W).head<2>().norm(), 1e-9);
  schedule_.legs[kFrontLeft].state = ContactState::kSwing;
  EXPECT_THAT(rig.Fix(block.schedule, schedule_).RunTo(0.3)[block.reference].com_W, IsNear(com, 1e-12))
      << "rests in the swing";
  schedule_.timing.stance = 0;
  ++schedule_.footsteps;
  rig.Fix(block.schedule, schedule_);
  EXPECT_TRUE(Throws<RunError>([&] { rig.RunTo(0.31); }, "stance_s"));
}

// The reference follows a robot that drifts, the commanded path does not.
TEST_F(ThesisPlannerTest, ThePathIsNotReset) {
  At(0.264);
  state_.p_WB[1] += 0.05;
  schedule_.footsteps = 2;
  rig_.Fix(block_.state, state_).Fix(block_.schedule, schedule_);
  At(0.265);
  QuadrupedModel(robot_).Calc(state_, &dynamics_);
  EXPECT_NEAR(rig_[block_.reference].com_W[1], dynamics_.com_W[1], 1e-12);
  EXPECT_THAT(rig_[block_.path].position_W,
              IsNear(Vec<2>(block_.stance.center_B + Vec<2>(0.12 * 0.265, 0)), 1e-12));
}

}  // namespace tenon::thesis_planner_test
