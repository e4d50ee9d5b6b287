#include <tenon/plants/surroundings/leash.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::leash_test {

const LeashParams kParams{
    .nominal_length = 1.5, .stiffness = 120, .dissipation = 0.5, .attachment_B = {-0.3, 0.1, 0.2}};

LeggedState Robot(const Vec<3>& p_WB, const Vec<3>& rotation = Vec<3>::Zero()) {
  LeggedState x;
  x.p_WB = p_WB;
  x.q_WB = QuaternionFromRotationVector(rotation);
  return x;
}

PersonState HandAt(const Vec<3>& hand_W) {
  PersonState person;
  person.hand_W = hand_W;
  return person;
}

TEST(LeashTest, IsASpringThatPullsOnly) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  // Turned by 90 degrees about z, B's (-0.3, 0.1, 0.2) is (-0.1, -0.3, 0.2) in W.
  rig.Fix(leash.robot, Robot({2.1, 0.3, 0.4}, {0, 0, std::acos(0.0)}));
  const Vec<3> attachment_W(2, 0, 0.6);
  const Vec<3> direction = Vec<3>(3, -1, 0.5).normalized();
  for (const double length : {0.2, 1.4999, 1.5, 1.5001, 1.75, 2.3}) {
    rig.Fix(leash.person, HandAt(attachment_W - length * direction));
    const double tension = length > 1.5 ? 120 * (length - 1.5) : 0;
    EXPECT_NEAR(rig[leash.leash].length, length, 1e-12);
    EXPECT_NEAR(rig[leash.leash].tension, tension, 1e-9) << length;
    EXPECT_THAT(rig[leash.leash].direction_W, IsNear(direction, 1e-12));
    const ExternalForce& force = rig[leash.force];
    EXPECT_EQ(force.body, 0);
    EXPECT_EQ(force.p_B, kParams.attachment_B);
    EXPECT_THAT(force.force_W, IsNear(Vec<3>(-tension * direction), 1e-9));
    EXPECT_TRUE(force.torque_W.isZero(0));
  }
}

// Damping is proportional to the rate of the length, here by finite differences of both positions.
TEST(LeashTest, DampsItsElongation) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  LeggedState robot = Robot({0.2, -0.1, 0.4}, {0.1, -0.2, 0.7});
  robot.v_W = {0.3, 0.2, -0.1};
  robot.w_W = {0.5, -1, 2};
  PersonState person = HandAt({-1.6, 0.3, 0.8});
  person.v_W = {-0.1, 0.25, 0};
  const auto at = [&](double t) {
    const Eigen::AngleAxisd turn(t * robot.w_W.norm(), robot.w_W.normalized());
    const Eigen::Vector3d end = robot.p_WB + t * robot.v_W + turn * robot.R_WB() * kParams.attachment_B;
    return (end - person.hand_W - t * person.v_W).norm();
  };
  const double rate = (at(1e-5) - at(-1e-5)) / 2e-5;
  ASSERT_GT(std::abs(rate), 0.1);
  rig.Fix(leash.robot, robot).Fix(leash.person, person);
  EXPECT_NEAR(rig[leash.leash].tension, 120 * (at(0) - 1.5) * (1 + 0.5 * rate), 1e-7);

  // If the ends approach so fast that the damping exceeds the spring, the leash is slack.
  person.v_W = 10 * rig[leash.leash].direction_W;
  rig.Fix(leash.person, person);
  EXPECT_EQ(rig[leash.leash].tension, 0);
}

TEST(LeashTest, AHandleAlsoPushes) {
  LeashParams params = kParams;
  params.handle = true;
  params.damping_time = 0.05;
  TestRig<Leash> rig(params);
  LeggedState robot = Robot({0, 0, 0.4});
  robot.v_W = {-0.3, 0.5, 0};
  for (const double length : {1.2, 1.5, 1.6}) {
    const Vec<3> attachment_W = robot.p_WB + kParams.attachment_B;
    rig.Fix(rig->robot, robot).Fix(rig->person, HandAt(attachment_W - Vec<3>(length, 0, 0)));
    const double tension = 120 * (length - 1.5 - 0.05 * 0.3);
    EXPECT_NEAR(rig[rig->leash].tension, tension, 1e-9) << length;
    EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(-tension, 0, 0), 1e-9));
  }
}

TEST(LeashTest, EndsInOnePlaceDoNotPull) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  rig.Fix(leash.robot, Robot({0.3, -0.1, -0.2})).Fix(leash.person, HandAt({0, 0, 0}));
  EXPECT_NEAR(rig[leash.leash].length, 0, 1e-15);
  EXPECT_EQ(rig[leash.leash].tension, 0);
  EXPECT_TRUE(rig[leash.force].force_W.isZero(0));
}

TEST(LeashTest, IsDrawnFromTheHandToTheTrunkColouredByTension) {
  TestRig<Leash> rig(kParams);
  rig.Fix(rig->robot, Robot({2.3, -0.1, 0.4})).Fix(rig->person, HandAt({0.25, 0, 0.6}));
  const Shape& rod = rig[rig->geometry].at(0);
  EXPECT_EQ(rod.kind, ShapeKind::kSegment);
  EXPECT_EQ(rod.unit, "N");
  EXPECT_THAT(rod.p_W, IsNear(Vec<3>(0.25, 0, 0.6), 1e-12));
  EXPECT_THAT(Vec<3>(rod.p_W + rod.vector_W), IsNear(Vec<3>(2, 0, 0.6), 1e-12));
  EXPECT_NEAR(rod.value, 120 * 0.25, 1e-9);
}

}  // namespace tenon::leash_test
