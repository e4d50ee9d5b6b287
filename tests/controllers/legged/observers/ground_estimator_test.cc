#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/tests/controllers/legged/planning/test_map.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::ground_estimator_test {

/// A robot that is put down on the ground repeatedly, each time 5 cm further and with the other pair of feet.
class Walk {
 public:
  explicit Walk(const GroundBelief& belief = {}) : rig_({.robot = robot_, .belief = belief}) {}

  const GroundPlane& Stand(const GroundPlane& ground) {
    rig_.Fix(rig_->state, StandingOn(robot_, ground)).Fix(rig_->schedule, schedule_).Tick();
    return rig_[rig_->ground];
  }
  /// Two steps on the ground, whose height at each pair of feet is off by up to `roughness`.
  const GroundPlane& Step(GroundPlane ground, double roughness = 0) {
    for (const auto& pair : {std::array{kFrontLeft, kRearRight}, std::array{kFrontRight, kRearLeft}}) {
      x_ += 0.05;
      const double height = ground.HeightAt({x_, 0});
      GroundPlane here = ground;
      here.p_W << x_, 0, height + roughness * random_.Uniform(-1, 1);
      for (const Leg leg : pair) schedule_.legs[leg].state = ContactState::kSwing;
      Stand(here);
      here.p_W[2] = height + roughness * random_.Uniform(-1, 1);
      for (const Leg leg : pair) schedule_.legs[leg].state = ContactState::kStance;
      Stand(here);
    }
    return rig_[rig_->ground];
  }
  TestRig<GroundEstimator>& rig() { return rig_; }
  const QuadrupedDescription& robot() const { return robot_; }

 private:
  QuadrupedDescription robot_ = test::DogBot();
  TestRig<GroundEstimator> rig_;
  ContactSchedule schedule_;
  RandomStream random_{3};
  double x_ = 0;
};

GroundPlane Ramp(double x, double y) {
  return {.p_W = {0, 0, 0.1}, .slope = {x, y}};
}

TEST(GroundEstimatorTest, EstimatesTheSlopeOnWhichItStands) {
  Walk walk;
  const GroundPlane& felt = walk.Stand(Ramp(0.3, -0.2));
  EXPECT_THAT(felt.slope, IsNear(Eigen::Vector2d(0.3, -0.2), 5e-3));
  EXPECT_NEAR(felt.HeightAt({0, 0}), 0.1, 2e-4);
  for (int n = 0; n < 20; ++n) walk.Step(Ramp(0.3, -0.2));
  EXPECT_THAT(felt.slope, IsNear(Eigen::Vector2d(0.3, -0.2), 0.02));
}

TEST(GroundEstimatorTest, FindsARampWithinSomeSteps) {
  Walk walk;
  for (int n = 0; n < 10; ++n) walk.Step({});
  for (int n = 0; n < 20; ++n) walk.Step(Ramp(0.2, 0));
  EXPECT_NEAR(walk.Step(Ramp(0.2, 0)).slope[0], 0.2, 0.06);
}

// Pairs of feet on blocks up to 4 cm high or in holes as deep.
TEST(GroundEstimatorTest, BlocksAreNoSlope) {
  const auto largest = [](const GroundBelief& belief) {
    Walk walk(belief);
    double slope = 0;
    for (int n = 0; n < 10; ++n) walk.Step({});
    for (int n = 0; n < 300; ++n) slope = std::max(slope, walk.Step({}, 0.04).slope.norm());
    return slope;
  };
  EXPECT_EQ(largest({}), 0);
  EXPECT_GT(largest({.doubt = 0}), 0.002);
}

TEST(GroundEstimatorTest, ThePlaneGoesThroughTheFeetThatStand) {
  Walk walk;
  walk.Stand({});
  LeggedState x = test::Standing(walk.robot());
  x.p_WB[2] += 0.04;  // not one foothold, but all that is seen from now on
  ContactSchedule schedule;
  schedule.legs[kFrontLeft].state = ContactState::kSearching;
  auto& rig = walk.rig();
  rig.Fix(rig->state, x).Fix(rig->schedule, schedule).Tick();
  EXPECT_NEAR(rig[rig->ground].p_W[2], 0.04, 1e-3);
  for (LegContact& leg : schedule.legs) leg.state = ContactState::kSwing;
  x.p_WB[2] += 1;  // in the air it stays
  rig.Fix(rig->state, x).Fix(rig->schedule, schedule).Tick();
  EXPECT_NEAR(rig[rig->ground].p_W[2], 0.04, 1e-3);
}

TEST(GroundEstimatorTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<GroundEstimator>({}, "robot"));
}

GroundPlane GroundOn(const ElevationMap& map, const LeggedState& state) {
  TestRig<MappedGround> rig(MappedGroundParams{.robot = test::DogBot()});
  rig.Fix(rig->map, map).Fix(rig->state, state).Tick();
  return rig[rig->ground];
}

TEST(MappedGroundTest, APlaneIsFoundExactly) {
  const ElevationMap map = test::MapOf([](double x, double y) { return 0.1 + 0.3 * x - 0.2 * y; });
  const LeggedState state{.p_WB = {0.2, -0.1, 0.4}, .q_WB = QuaternionFromRotationVector({0, 0, 0.7})};
  const GroundPlane ground = GroundOn(map, state);
  EXPECT_THAT(ground.slope, IsNear(Eigen::Vector2d(0.3, -0.2), 1e-9));
  EXPECT_NEAR(ground.HeightAt({0, 0}), 0.1, 1e-9);
}

// The middle of stairs rises like the line through their edges.
TEST(MappedGroundTest, StairsHaveTheirMeanSlope) {
  const ElevationMap map = test::MapOf([](double x, double) { return 0.12 * std::floor(x / 0.3 + 0.5); });
  const GroundPlane ground = GroundOn(map, LeggedState());
  EXPECT_NEAR(ground.slope[0], 0.4, 0.06);
  EXPECT_NEAR(ground.slope[1], 0, 1e-9);
  EXPECT_NEAR(ground.HeightAt({0, 0}), 0, 0.02);
}

TEST(MappedGroundTest, WithoutAMapTheGroundIsLevel) {
  EXPECT_EQ(GroundOn(ElevationMap(), LeggedState()).slope, Eigen::Vector2d(0, 0));
}

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

}  // namespace tenon::ground_estimator_test
