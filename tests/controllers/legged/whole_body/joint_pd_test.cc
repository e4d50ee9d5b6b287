#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::joint_pd_test {

using test::A1;
using test::DogBot;

JointPdParams Params(const QuadrupedDescription& robot) {
  JointPdParams params;
  params.robot = robot;
  params.stiffness = 40;
  params.damping = 2;
  return params;
}

// Virtual work: when the joints move by dq with the feet on the ground, the torques do the work that lifts
// the robot. With all knees and hips moving alike the trunk moves up without turning.
TEST(StandingTorqueTest, DoesTheWorkThatLiftsTheRobot) {
  for (QuadrupedDescription robot : {DogBot(), A1()}) {
    const auto potential = [&](double s) {  // of the robot on its feet, the stance changed by s
      LeggedState x;
      x.q = robot.stance;
      for (int leg = 0; leg < kNumLegs; ++leg) x.q.segment<2>(3 * leg + 1) += s * Vec<2>(1, -2);
      double depth = 0;
      for (int leg = 0; leg < kNumLegs; ++leg) depth -= robot.FootPosition(leg, x.q)[2] / kNumLegs;
      const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(robot), x);
      return robot.mass() * 9.81 * (dynamics.com_W[2] + depth);
    };
    // Legs alike in front and rear, so that the trunk stays level.
    const Vec<12> torque = StandingTorque(robot, 9.81);
    double work = 0;
    for (int leg = 0; leg < kNumLegs; ++leg) work += torque.segment<2>(3 * leg + 1).dot(Vec<2>(1, -2));
    const double h = 1e-5;
    // The feet also move horizontally, which takes no work because the forces are vertical.
    EXPECT_NEAR(work, (potential(h) - potential(-h)) / (2 * h), 1e-6 * std::abs(work)) << robot.name;
    EXPECT_GT(std::abs(work), 1);
  }
}

TEST(StandingTorqueTest, RefusesFeetInALine) {
  QuadrupedDescription robot = DogBot();
  for (LegDescription& leg : robot.legs) {
    for (JointDescription& joint : leg.joints) joint.p_PJ[1] = 0;
    leg.foot_J[1] = 0;
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { StandingTorque(robot, 9.81); }, "dogbot"));
}

TEST(JointPdTest, IsTheEquationWithinTheLimits) {
  JointPdParams params = Params(DogBot());
  TestRig<JointPd> rig(params);
  JointMotion joints{params.robot.stance, Vec<12>::Zero()};
  joints.q[2] -= 0.1;
  joints.qd[4] = 0.5;
  joints.q[8] += 100;
  rig.Fix(rig->joints, joints).Tick();
  Vec<12> expected = StandingTorque(params.robot, 9.81);
  expected[2] += 40 * 0.1;
  expected[4] -= 2 * 0.5;
  expected[8] = -60;
  EXPECT_THAT(rig[rig->torque], IsNear(expected, 1e-12));
}

TEST(JointPdTest, FollowsItsReferenceWithoutGravityCompensation) {
  JointPdParams params = Params(A1());
  params.gravity_compensation = false;
  TestRig<JointPd> rig(params);
  rig.Fix(rig->joints, JointMotion{}).Fix(rig->reference, Vec<12>::Constant(0.2)).Tick();
  EXPECT_THAT(rig[rig->torque], IsNear(Vec<12>::Constant(8), 1e-12));
}

TEST(JointPdTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<JointPd>({}, "robot"));
  EXPECT_TRUE(Refuses<JointPd>({.robot = DogBot(), .stiffness = 40, .gravity = INFINITY}, "gravity"));
}

}  // namespace tenon::joint_pd_test
