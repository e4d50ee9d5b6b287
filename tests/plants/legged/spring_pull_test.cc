#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::spring_pull_test {
namespace {

LeggedState After(const LeggedState& x, double dt) {
  LeggedState next = x;
  next.p_WB += dt * x.v_W;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(dt * x.w_W.norm(), x.w_W.normalized()).toRotationMatrix() * x.R_WB();
  next.q_WB = QuaternionFromRotation(R);
  next.q += dt * x.qd;
  return next;
}

// Positions from Simbody, velocities from their differences in time.
TEST(SpringPullTest, ComputesPositionsAndVelocitiesOfPoints) {
  const QuadrupedDescription robot = test::SkewDogBot();
  RandomStream random(1);
  for (int body = 0; body <= kNumJoints; ++body) {
    const LeggedState x = test::RandomState(random);
    const Vec<3> p_B = test::RandomVector<3>(random, 0.2);
    QuadrupedBody bodies(robot);
    const auto place = [&](double dt) {
      bodies.SetState(After(x, dt));
      return bodies.Position(body, p_B);
    };
    const BodyPoint point = PointOfBody(robot, x, body, p_B);
    EXPECT_THAT(point.p_W, IsNear(place(0), 1e-12)) << body;
    EXPECT_THAT(point.v_W, IsNear(Vec<3>((place(1e-5) - place(-1e-5)) / 2e-5), 1e-8)) << body;
    EXPECT_THAT(PointInBody(robot, x, body, point.p_W), IsNear(p_B, 1e-12)) << body;
  }
}

TEST(SpringPullTest, PullsByHooksLawUpToItsLargestForce) {
  TestRig<SpringPull> rig(
      SpringPullParams{.robot = test::DogBot(), .stiffness = 100, .damping = 10, .max_force = 50});
  LeggedState x;
  x.p_WB = {1, 2, 0.5};
  x.v_W = {0, 0.5, 0};
  rig.Fix(rig->state, x);
  EXPECT_TRUE(rig[rig->force].force_W.isZero(0));
  rig.Set(rig->grip, {true, 0, {0.1, 0, 0}, {1.1, 2, 0.8}});
  EXPECT_EQ(rig[rig->force].body, 0);
  EXPECT_THAT(rig[rig->force].p_B, IsNear(Vec<3>(0.1, 0, 0), 0));
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, -5, 30), 1e-12));
  rig.Set(rig->grip, {true, 0, {0.1, 0, 0}, {1.1, 2.05, 9}});
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, 50), 1e-12));
}

TEST(SpringPullTest, ItsDefaultsFollowFromTheRobotsWeight) {
  const QuadrupedDescription robot = test::DogBot();
  TestRig<SpringPull> rig(SpringPullParams{.robot = robot});
  EXPECT_NEAR(rig->params.max_force, 9.81 * robot.mass(), 1e-9);
  EXPECT_NEAR(0.25 * rig->params.stiffness, 9.81 * robot.mass() / 2, 1e-9);
}

TEST(SpringPullTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<SpringPull>({}, "robot"));
  EXPECT_TRUE(Refuses<SpringPull>({.robot = test::DogBot(), .damping = -1}, "-1 N s/m"));
  TestRig<SpringPull> rig(SpringPullParams{.robot = test::DogBot()});
  rig.Fix(rig->state, LeggedState());
  rig.Set(rig->grip, {true, 13, Vec<3>::Zero(), Vec<3>::Zero()});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->force]; }, "body 13"));
}

}  // namespace
}  // namespace tenon::spring_pull_test
