#include <tenon/diagrams/evaluation/leg_errors.h>
#include <tenon/plants/legged/disturbances.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::leg_errors_test {

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
  LegForceEstimate estimate;
  estimate.joint_torque = 1.1 * TorqueOf(external[1]);
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

}  // namespace tenon::leg_errors_test
