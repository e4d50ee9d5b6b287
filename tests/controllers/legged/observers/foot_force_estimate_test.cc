#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::foot_force_estimate_test {
namespace {

FootForces SomeForces() {
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg) forces[leg] = Vec<3>(3 * leg - 4, 7 - leg, 60 + 5 * leg);
  return forces;
}

/// A measured force along the shank points from the knee to the foot in the world.
TEST(FootForceEstimateTest, TurnsMeasuredForcesIntoTheWorld) {
  RandomStream random(4);
  const QuadrupedDescription robot = test::DogBot();
  const LeggedState x = test::RandomState(random);
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(robot), x);
  FootForces shank;
  for (int leg = 0; leg < kNumLegs; ++leg) shank[leg] = robot.legs[leg].foot_J;
  TestRig<FootForceEstimate> rig(FootForceEstimateParams{.robot = robot});
  rig.Fix(rig->shank, shank).Fix(rig->joints, {x.q, x.qd}).Fix(rig->state, x).Tick().Tick();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Vec<3> knee = dynamics.origin_W[kJointsPerLeg * leg + 2];
    EXPECT_THAT(rig[rig->forces][leg], IsNear(Vec<3>(dynamics.feet[leg].p_W - knee), 1e-12)) << leg;
  }
}

TEST(FootForceEstimateTest, UsesTheAttitudeOfTheTickBefore) {
  const QuadrupedDescription robot = test::DogBot();
  LeggedState x = test::Standing(robot);
  TestRig<FootForceEstimate> rig(FootForceEstimateParams{.robot = robot});
  rig.Fix(rig->shank, SomeForces()).Fix(rig->joints, {x.q, x.qd}).Fix(rig->state, x).Tick().Tick();
  const FootForces level = rig[rig->forces];
  x.q_WB = {0, 1, 0, 0};  // on its back
  rig.Fix(rig->state, x);
  EXPECT_EQ(rig[rig->forces][kRearLeft], level[kRearLeft]);
  rig.Tick().Tick();
  EXPECT_THAT(rig[rig->forces][kRearLeft],
              IsNear(Vec<3>(level[kRearLeft].cwiseProduct(Vec<3>(1, -1, -1))), 1e-12));
}

}  // namespace
}  // namespace tenon::foot_force_estimate_test
