#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::ground_force_observer_test {
namespace {

/// What forces do at the joints of a robot that stands, where its feet touch this ground.
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

TEST(GroundForceObserverTest, TellsTheForcesThatTheJointsFeel) {
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

TEST(GroundForceObserverTest, OnlyWhatPressesOnTheGroundIsAStance) {
  Standing standing;
  EXPECT_EQ(standing.Observe(All({60, 0, -20}))[kFrontLeft], Vec<3>(Vec<3>::Zero()));
}

TEST(GroundForceObserverTest, DoesNotAllocate) {
  Standing standing;
  standing.Observe(All({0, 0, 50}));
  AllocationGuard guard;
  standing.rig.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(GroundForceObserverTest, RefusesWhatMakesNoSense) {
  const auto check = [](const ContactThresholds& thresholds) {
    GroundForceObserverParams{.robot = test::DogBot(), .thresholds = thresholds}.Validate();
  };
  EXPECT_TRUE(Throws<ParameterError>([&] { check({.touch = 0.1, .leave = 0.2}); }, "leave", "touch"));
  EXPECT_TRUE(Throws<ParameterError>([&] { check({.touch = 0.1, .leave = 0}); }, "leave"));
  EXPECT_TRUE(
      Throws<ParameterError>([] { GroundForceObserverParams().Validate(); }, "robot"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { GroundForceObserverParams{.robot = test::DogBot(), .min_singular_value = 0}.Validate(); },
      "min_singular_value = 0 m"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { GroundForceObserverParams{.robot = test::DogBot(), .gravity = 0}.Validate(); },
      "gravity is 0 m/s^2"));
}

}  // namespace
}  // namespace tenon::ground_force_observer_test
