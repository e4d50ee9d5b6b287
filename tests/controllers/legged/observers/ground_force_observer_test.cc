#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::ground_force_observer_test {

/// The joint torques of forces on the feet of a robot that stands on the ground.
struct Standing {
  explicit Standing(const GroundPlane& plane = {}) : ground(plane) {
    QuadrupedModel(robot).Calc(state, &dynamics);
  }
  LegForceEstimate JointsOf(const FootForces& forces) const {
    LegForceEstimate felt;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Eigen::Matrix3d J = dynamics.Contact(leg, ground.ContactArm(robot.foot_radius)).J_leg;
      felt.joint_torque.segment<3>(3 * leg) = J.transpose() * forces[leg];
    }
    return felt;
  }
  FootForces Observe(const FootForces& forces) {
    rig.Fix(rig->state, state).Fix(rig->leg_forces, JointsOf(forces)).Fix(rig->ground, ground).Tick();
    return rig[rig->forces];
  }

  QuadrupedDescription robot = test::DogBot();
  GroundPlane ground;
  LeggedState state = test::Standing(robot);
  QuadrupedDynamics dynamics;
  TestRig<GroundForceObserver> rig{GroundForceObserverParams{.robot = robot}};
};

FootForces All(const Vec<3>& force) {
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg) forces[leg] = force;
  return forces;
}

TEST(GroundForceObserverTest, EstimatesForcesFromJointTorques) {
  for (const Vec<2>& slope : {Vec<2>(0, 0), Vec<2>(0.3, -0.2)}) {
    Standing standing({.p_W = Vec<3>::Zero(), .slope = slope});
    FootForces forces = All({3, -8, 51});
    forces[kRearLeft] = Vec<3>(-5, 1, 33);
    const FootForces observed = standing.Observe(forces);
    for (int leg = 0; leg < kNumLegs; ++leg) EXPECT_THAT(observed[leg], IsNear(forces[leg], 1e-9)) << leg;
  }
}

// DogBot weighs 206 N: 25 N are a touchdown, and 8 N no longer a stance.
TEST(GroundForceObserverTest, AFootComesAndGoesAtDifferentForces) {
  Standing standing;
  const auto stands = [&](double force) { return standing.Observe(All({0, 0, force}))[kFrontLeft][2] > 0; };
  EXPECT_TRUE(stands(20));
  EXPECT_TRUE(stands(9));
  EXPECT_FALSE(stands(8));
  EXPECT_FALSE(stands(20));
  EXPECT_TRUE(stands(26));
  EXPECT_TRUE(stands(20));
}

TEST(GroundForceObserverTest, OnlyAFootThatPressesOnTheGroundStands) {
  Standing standing;
  EXPECT_EQ(standing.Observe(All({60, 0, -20}))[kFrontLeft], Vec<3>(Vec<3>::Zero()));
}

TEST(GroundForceObserverTest, RefusesNonsense) {
  const QuadrupedDescription robot = test::DogBot();
  using Observer = GroundForceObserver;
  EXPECT_TRUE(Refuses<Observer>({}, "robot"));
  EXPECT_TRUE(
      Refuses<Observer>({.robot = robot, .thresholds = {.touch = 0.1, .leave = 0.2}}, "leave", "touch"));
  EXPECT_TRUE(Refuses<Observer>({.robot = robot, .min_singular_value = 0}, "min_singular_value"));
  EXPECT_TRUE(Refuses<Observer>({.robot = robot, .gravity = 0}, "gravity"));
}

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

}  // namespace tenon::ground_force_observer_test
