#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/model/standing.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::standing_test {
namespace {

TEST(StandingTest, IsTheNominalStanceOnLevelGround) {
  const QuadrupedDescription robot = test::DogBot();
  const LeggedState x = StandingOn(robot, {});
  EXPECT_EQ(x.q, robot.stance);
  EXPECT_THAT(x.p_WB, IsNear(test::Standing(robot).p_WB, 1e-12));
  EXPECT_THAT(x.R_WB(), IsNear(Eigen::Matrix3d::Identity(), 1e-15));
}

TEST(StandingTest, FeetTouchASlopeAndTheCoMIsOverThem) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1()}) {
    QuadrupedDynamics level, on_slope;
    QuadrupedModel(robot).Calc(test::Standing(robot), &level);
    const GroundPlane ground{.p_W = {2, -1, 0.3}, .slope = {0.3, -0.2}};
    const LeggedState x = StandingOn(robot, ground, 0.8);
    QuadrupedModel(robot).Calc(x, &on_slope);
    EXPECT_THAT(x.R_WB().col(2), IsNear(ground.Normal(), 1e-12));
    Vec<3> middle = Vec<3>::Zero(), nominal = Vec<3>::Zero();
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      const Vec<3> contact = on_slope.feet[leg].p_W + ground.ContactArm(robot.foot_radius);
      EXPECT_NEAR(contact[2], ground.HeightAt(contact.head<2>()), 1e-8) << kLegNames[leg];
      middle += on_slope.feet[leg].p_W / kNumLegs;
      nominal += level.feet[leg].p_W / kNumLegs;
    }
    const Eigen::Vector2d com = (level.com_W - nominal).head<2>();
    EXPECT_THAT((on_slope.com_W - middle).head<2>(), IsNear(FootprintOnSlope(ground.slope, 0.8) * com, 1e-8));
    EXPECT_NEAR(on_slope.com_W[2] - ground.HeightAt(on_slope.com_W.head<2>()), level.com_W[2], 1e-8);
  }
}

TEST(StandingTest, TheFeetMayBeShifted) {
  const QuadrupedDescription robot = test::DogBot();
  const GroundPlane ground{.p_W = {0, 0, 0}, .slope = {0.3, 0}};
  const Vec<2> shift(0.08, 0.02);
  QuadrupedDynamics plain, shifted;
  QuadrupedModel(robot).Calc(StandingOn(robot, ground), &plain);
  QuadrupedModel(robot).Calc(StandingOn(robot, ground, 0, shift), &shifted);
  EXPECT_THAT(shifted.com_W, IsNear(plain.com_W, 1e-8));
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(Vec<3>(shifted.feet[leg].p_W - plain.feet[leg].p_W), IsNear(Vec<3>(0.08, 0.02, 0.024), 1e-8));
}

TEST(StandingTest, NamesTheLegThatDoesNotReach) {
  QuadrupedDescription robot = test::DogBot();
  JointDescription& hip = robot.legs[kRearLeft].joints[1];
  hip.lower = robot.stance[7] - 0.1;
  hip.upper = robot.stance[7] + 0.1;
  const GroundPlane gentle{.p_W = {0, 0, 0}, .slope = {0.05, 0}}, steep{.p_W = {0, 0, 0}, .slope = {0.4, 0}};
  EXPECT_NO_THROW(StandingOn(robot, gentle));
  EXPECT_TRUE(Throws<ParameterError>([&] { StandingOn(robot, steep); }, "rear_left", "dogbot"));
}

}  // namespace
}  // namespace tenon::standing_test
