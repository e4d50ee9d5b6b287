#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::tracking_error_test {

class TrackingErrorTest : public ::testing::Test {
 protected:
  TrackingErrorTest() {
    QuadrupedModel(robot_).Calc(state_, &dynamics_);
    auto& block = rig_.system();
    rig_.Fix(block.state, state_)
        .Fix(block.told, state_)
        .Fix(block.foot_forces, FootForces())
        .Fix(block.schedule, ContactSchedule());
    rig_.Fix(block.body, BodyReference()).Fix(block.feet, FeetReference()).Fix(block.plan, WholeBodyPlan());
  }
  QuadrupedDescription robot_ = test::DogBot();
  LeggedState state_ = test::Standing(robot_);
  QuadrupedDynamics dynamics_;
  TestRig<TrackingError> rig_{TrackingErrorParams{robot_}};
};

TEST_F(TrackingErrorTest, IsTheDifferenceOfPlanAndState) {
  auto& block = rig_.system();
  BodyReference body;
  body.com_W = dynamics_.com_W - Vec<3>(0.01, 0.02, -0.03);
  FeetReference feet;
  feet[kRearLeft].p_W = dynamics_.feet[kRearLeft].p_W + Vec<3>(0.003, 0, 0.004);
  ContactSchedule schedule;
  schedule.legs[kRearLeft].state = ContactState::kSwing;
  schedule.legs[kRearRight].state = ContactState::kLate;
  WholeBodyPlan plan;
  plan.solution.force[kFrontLeft] = Vec<3>(3, 0, 50);
  FootForces forces;
  forces[kFrontLeft] = Vec<3>(0, 4, 50);
  forces[kRearRight] = Vec<3>(0, 0, 50);
  rig_.Fix(block.body, body).Fix(block.feet, feet).Fix(block.schedule, schedule).Fix(block.plan, plan);
  const WalkingErrors errors = rig_.Fix(block.foot_forces, forces)[block.errors];
  EXPECT_THAT(errors.com, IsNear(Vec<3>(0.01, 0.02, -0.03), 1e-14));
  EXPECT_THAT(errors.com_position, IsNear(dynamics_.com_W, 1e-14));
  EXPECT_THAT(errors.foot, IsNear(Vec<4>(0, 0, 0.005, 0), 1e-14));
  EXPECT_THAT(errors.ground_force, IsNear(Vec<4>(5, 0, 0, 0), 1e-14));
}

// A drift of the estimated position and heading, which the robot cannot observe, is no error of the path.
TEST_F(TrackingErrorTest, DriftIsNoPathError) {
  auto& block = rig_.system();
  const Eigen::AngleAxisd turn(0.7, Vec<3>::UnitZ());
  const Vec<3> shift(2, -1, 0.05);
  LeggedState told = state_;
  told.p_WB = shift + turn * state_.p_WB;
  const Eigen::Quaterniond q = turn * Eigen::Quaterniond(state_.R_WB());
  told.q_WB = {q.w(), q.x(), q.y(), q.z()};
  BodyReference body;
  body.com_W = shift + turn * dynamics_.com_W;
  FeetReference feet;
  feet[kRearLeft].p_W = shift + turn * dynamics_.feet[kRearLeft].p_W + Vec<3>(0, 0.003, 0.004);
  ContactSchedule schedule;
  schedule.legs[kRearLeft].state = ContactState::kSwing;
  rig_.Fix(block.told, told).Fix(block.body, body).Fix(block.feet, feet).Fix(block.schedule, schedule);
  const PathErrors path = rig_[block.path];
  EXPECT_THAT(path.com, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_THAT(path.foot, IsNear(Vec<4>(0, 0, 0.005, 0), 1e-12));
  EXPECT_THAT(path.drift, IsNear(Vec<3>(told.p_WB - state_.p_WB), 1e-12));
  EXPECT_NEAR(path.yaw_drift, 0.7, 1e-12);
  EXPECT_GT(rig_[block.errors].com.norm(), 1);
}

// The joint torques of a force at a foot give this force.
TEST_F(TrackingErrorTest, MapsExternalTorquesToForcesAtTheFeet) {
  auto& block = rig_.system();
  EXPECT_EQ(rig_[block.external_foot_forces][kFrontRight].norm(), 0) << "none connected";
  const Vec<3> force(10, -20, 5);
  Vec<12> torque = Vec<12>::Zero();
  torque.segment<3>(3 * kFrontRight) = dynamics_.feet[kFrontRight].J_leg.transpose() * force;
  rig_.Fix(block.external_torque, torque);
  EXPECT_THAT(rig_[block.external_foot_forces][kFrontRight], IsNear(force, 1e-9));
  EXPECT_EQ(rig_[block.external_foot_forces][kRearLeft].norm(), 0);
}

TEST_F(TrackingErrorTest, TheLeastSingularValueIsSetInARun) {
  auto& block = rig_.system();
  const Vec<12> torque = Vec<12>::Constant(3);
  TestRig<TrackingError> built(TrackingErrorParams{robot_, 0.5});
  built.Fix(built->state, state_).Fix(built->external_torque, torque);
  rig_.Fix(block.external_torque, torque);
  const FootForces expected = built[built->external_foot_forces];
  EXPECT_NE(rig_[block.external_foot_forces][kFrontLeft], expected[kFrontLeft]);
  rig_.Set(block.min_singular_value, 0.5);
  EXPECT_EQ(rig_[block.external_foot_forces][kFrontLeft], expected[kFrontLeft]);
}

TEST(WalkViewTest, ArrowsStartAtCentreAndFeet) {
  TestRig<WalkView> rig(WalkViewParams{test::DogBot()});
  const WalkView& view = rig.system();
  RandomStream random(2);
  const LeggedState x = test::RandomState(random);
  QuadrupedDynamics dynamics;
  QuadrupedModel(test::DogBot()).Calc(x, &dynamics);
  BodyReference body;
  body.com_W << 1, 2, 3;
  LegForceEstimate legs;
  legs.foot_force[kRearLeft] << 4, 5, 6;
  rig.Fix(view.state, x)
      .Fix(view.body, body)
      .Fix(view.wrench, WrenchEstimate{{7, 8, 9}, {}})
      .Fix(view.leg_forces, legs);
  const Geometry& shapes = rig[view.geometry];
  ASSERT_EQ(shapes.size(), 6);
  EXPECT_EQ(shapes[0].p_W, body.com_W);
  EXPECT_EQ(shapes[1].vector_W, Vec<3>(7, 8, 9));
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(shapes[2 + leg].p_W, IsNear(dynamics.feet[leg].p_W, 1e-12));
  EXPECT_EQ(shapes[2 + kRearLeft].vector_W, Vec<3>(4, 5, 6));
  EXPECT_EQ(shapes[2 + kFrontLeft].vector_W, Vec<3>(0, 0, 0));
}

}  // namespace tenon::tracking_error_test
