#include <tenon/diagrams/evaluation/leg_errors.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/plants/legged/disturbances.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::evaluation_test {

class LegErrorsTest : public ::testing::Test {
 protected:
  LegErrorsTest() {
    rig_.Fix(block_.state, state_).Fix(block_.schedule, schedule_).Fix(block_.feet, FeetReference());
  }
  Vec<3> Foot(int leg) const { return state_.p_WB + state_.R_WB() * robot_.FootPosition(leg, state_.q); }

  /// Torque by virtual work: the change of a point of a leg with its joints, by central differences.
  Vec<12> TorqueOf(const ExternalForce& force) const {
    Vec<12> torque = Vec<12>::Zero();
    const int leg = (force.body - 1) / kJointsPerLeg;
    const auto body = static_cast<std::size_t>(force.body - 1 - kJointsPerLeg * leg);
    const auto at = [&](int joint, double step) -> Vec<3> {
      LeggedState x = state_;
      x.q[joint] += step;
      const LegPose pose = robot_.PoseOfLeg(leg, x.q);
      return x.R_WB() * (pose.p_BJ[body] + pose.R_BJ[body] * force.p_B);
    };
    for (int j = kJointsPerLeg * leg; j < kJointsPerLeg * (leg + 1); ++j)
      torque[j] = force.force_W.dot(at(j, 1e-5) - at(j, -1e-5)) / 2e-5;
    return torque;
  }

  QuadrupedDescription robot_ = test::DogBot();
  LeggedState state_ = [this] {
    RandomStream random(3);
    LeggedState x = test::RandomState(random);
    x.q = test::Standing(robot_).q;
    return x;
  }();
  ContactSchedule schedule_;
  TestRig<LegErrors> rig_{LegErrorsParams{.robot = robot_}};
  const LegErrors& block_ = rig_.system();
};

// A force on the shank moves three joints, which determine it.
TEST_F(LegErrorsTest, FindsAForceOnTheShank) {
  ExternalForces external;
  external[1] = PointOnLeg(robot_, kRearLeft, 0.2);
  external[1].force_W << 12, -7, 9;
  const LegForceEstimate estimate{.joint_torque = 1.1 * TorqueOf(external[1])};
  rig_.Fix(block_.external, external).Fix(block_.external_torque, TorqueOf(external[1]));
  const ForcesAtPoints at = rig_.Fix(block_.leg_forces, estimate)[block_.forces];
  EXPECT_THAT(at.force[kRearLeft], IsNear(external[1].force_W, 1e-6));
  EXPECT_THAT(at.estimate[kRearLeft], IsNear(Vec<3>(1.1 * external[1].force_W), 1e-6));
  EXPECT_NEAR(at.error[kRearLeft], 0.1 * external[1].force_W.norm(), 1e-6);
  EXPECT_EQ(at.force[kFrontLeft], Vec<3>::Zero().eval());
}

// A force on the thigh moves two joints: the found part has the same torques, and no part that no joint
// feels.
TEST_F(LegErrorsTest, FindsThePartOfAForceOnTheThighThatTheJointsFeel) {
  ExternalForces external;
  external[0] = PointOnLeg(robot_, kFrontRight, 0.7);
  external[0].force_W << 20, 5, -3;
  const Vec<12> torque = TorqueOf(external[0]);
  EXPECT_NEAR(torque[3 * kFrontRight + 2], 0, 1e-8) << "the knee";
  const ForcesAtPoints at =
      rig_.Fix(block_.external, external).Fix(block_.external_torque, torque)[block_.forces];
  ExternalForce found = external[0];
  found.force_W = at.force[kFrontRight];
  EXPECT_THAT(TorqueOf(found), IsNear(torque, 0.03 * torque.norm())) << "but for the damping of the solution";
  EXPECT_LT(found.force_W.norm(), external[0].force_W.norm());
  EXPECT_NEAR(found.force_W.dot(external[0].force_W) / found.force_W.squaredNorm(), 1, 0.03)
      << "a projection";
}

TEST_F(LegErrorsTest, ALegWithoutAForceHasItsPointAtTheFoot) {
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot_).Calc(state_, &dynamics);
  const Vec<3> force(3, 4, 12);
  LegForceEstimate estimate;
  estimate.joint_torque.segment<3>(3 * kFrontLeft) = dynamics.foot(kFrontLeft).J_leg.transpose() * force;
  const ForcesAtPoints at = rig_.Fix(block_.leg_forces, estimate)[block_.forces];
  EXPECT_THAT(at.estimate[kFrontLeft], IsNear(force, 1e-9));
  EXPECT_NEAR(at.error[kFrontLeft], 13, 1e-9);
}

// A foot that lands 0.04 m above its planned foothold keeps this error until it swings again.
TEST_F(LegErrorsTest, AFootOnABlockHasTheHeightOfTheBlockAsError) {
  LegErrors::Points footholds = LegErrors::Origins();
  footholds.fill(Foot(kRearRight) - Vec<3>(0, 0, 0.04));
  FeetReference feet;
  feet[kRearRight].p_W = Foot(kRearRight) - Vec<3>(0.003, 0, 0.004);
  rig_.Fix(block_.footholds, footholds).Fix(block_.feet, feet);
  const auto errors = [&](ContactState state) {
    schedule_.legs[kRearRight].state = state;
    return rig_.Fix(block_.schedule, schedule_).Tick()[block_.foot];
  };
  EXPECT_THAT(errors(ContactState::kStance), IsNear(Vec<4>(0, 0, 0, 0), 0)) << "has not stepped yet";
  EXPECT_THAT(errors(ContactState::kSwing), IsNear(Vec<4>(0, 0, 0, 0.005), 1e-12));
  footholds.fill(Vec<3>(1, 2, 3));  // of a stance foot, without effect
  rig_.Fix(block_.footholds, footholds);
  EXPECT_THAT(errors(ContactState::kStance), IsNear(Vec<4>(0, 0, 0, 0.04), 1e-12));
  EXPECT_THAT(errors(ContactState::kLate), IsNear(Vec<4>(0, 0, 0, 0.04), 1e-12));
}

TEST_F(LegErrorsTest, ShowsThePlannedFootholds) {
  LegErrors::Points footholds = LegErrors::Origins();
  for (std::size_t i = 0; i < kNumLegs; ++i) footholds[i] << static_cast<double>(i), 1, 2;
  const Geometry& shapes = rig_.Fix(block_.footholds, footholds)[block_.geometry];
  ASSERT_EQ(shapes.size(), 4);
  EXPECT_EQ(shapes[2].p_W, Vec<3>(2, 1, 2));
  EXPECT_EQ(shapes[2].name, "planned foothold of rear_left");
}

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
  const BodyReference body{.com_W = dynamics_.com_W - Vec<3>(0.01, 0.02, -0.03)};
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
  FeetReference feet;
  feet[kRearLeft].p_W = shift + turn * dynamics_.feet[kRearLeft].p_W + Vec<3>(0, 0.003, 0.004);
  ContactSchedule schedule;
  schedule.legs[kRearLeft].state = ContactState::kSwing;
  rig_.Fix(block.told, told)
      .Fix(block.body, {.com_W = shift + turn * dynamics_.com_W})
      .Fix(block.feet, feet)
      .Fix(block.schedule, schedule);
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
  const BodyReference body{.com_W = {1, 2, 3}};
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

}  // namespace tenon::evaluation_test
