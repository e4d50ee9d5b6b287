#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/quaternion.h>
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
  LeggedState state;
  state.p_WB << 0.2, -0.1, 0.4;
  state.q_WB = QuaternionFromRotationVector({0, 0, 0.7});
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

}  // namespace tenon::ground_estimator_test
