#include <tenon/plants/surroundings/obstacle_detector.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::obstacle_detector_test {

const ObstacleDetectorParams kParams{
    .obstacles = {{{3, 0}, 0.2}, {{-5, 4}, 0.5}}, .range = 1, .half_width = 0.4};

bool Sees(double x, double y, double yaw) {
  TestRig<ObstacleDetector> rig(kParams);
  LeggedState state;
  state.p_WB = {x, y, 0.4};
  state.q_WB = QuaternionFromRotationVector({0, 0, yaw});
  rig.Fix(rig->state, state);
  return rig[rig->obstacle];
}

TEST(ObstacleDetectorTest, SeesObstaclesAheadInRange) {
  EXPECT_FALSE(Sees(1.79, 0, 0));
  EXPECT_TRUE(Sees(1.81, 0, 0)) << "the surface of the pillar is at 2.8 m";
  EXPECT_TRUE(Sees(2.9, 0, 0));
  EXPECT_FALSE(Sees(3.1, 0, 0)) << "behind";
  EXPECT_FALSE(Sees(2, 0, 3));
}

TEST(ObstacleDetectorTest, LooksAsWideAsTheRobotsWay) {
  EXPECT_TRUE(Sees(2, 0.59, 0));
  EXPECT_FALSE(Sees(2, 0.61, 0));
  EXPECT_TRUE(Sees(2, -0.59, 0));
  EXPECT_FALSE(Sees(2, -0.61, 0));
}

// All lengths are exact in binary.
TEST(ObstacleDetectorTest, TheBoundsOfItsViewAreExcluded) {
  TestRig<ObstacleDetector> rig(
      ObstacleDetectorParams{.obstacles = {{{3, 0}, 0.25}}, .range = 1, .half_width = 0.5});
  const auto sees = [&](double x, double y) {
    LeggedState state;
    state.p_WB = {x, y, 0.5};
    rig.Fix(rig->state, state);
    return rig[rig->obstacle];
  };
  EXPECT_FALSE(sees(2.5, 0.75));
  EXPECT_FALSE(sees(2.5, -0.75));
  EXPECT_FALSE(sees(1.75, 0));
  EXPECT_FALSE(sees(3, 0)) << "beside, if it could be there";
  EXPECT_TRUE(sees(1.75 + 1e-9, 0.75 - 1e-9));
}

TEST(ObstacleDetectorTest, TurnsWithTheRobotAndSeesAllObstacles) {
  EXPECT_TRUE(Sees(-5, 2.6, 1.57));
  EXPECT_FALSE(Sees(-5, 2.4, 1.57));
  EXPECT_FALSE(Sees(-5, 2.6, 0));
}

TEST(ObstacleDetectorTest, KeepsAnObstacleInSightThatTheRobotSwaysAwayFrom) {
  TestRig<ObstacleDetector> rig(kParams);
  const auto in_sight = [&](double x) {
    LeggedState state;
    state.p_WB = {x, 0, 0.4};
    rig.Fix(rig->state, state);
    return rig.Tick()[rig->in_sight];
  };
  EXPECT_FALSE(in_sight(1.79));
  EXPECT_TRUE(in_sight(1.81));
  EXPECT_TRUE(in_sight(1.76)) << "0.04 m beyond the range";
  EXPECT_FALSE(in_sight(1.74)) << "0.06 m";
  EXPECT_FALSE(in_sight(1.76)) << "it would be a new one";
}

TEST(ObstacleDetectorTest, DrawsThePillars) {
  TestRig<ObstacleDetector> rig(kParams);
  rig.Fix(rig->state, LeggedState());
  const Geometry& shapes = rig[rig->geometry];
  ASSERT_EQ(shapes.size(), 2U);
  EXPECT_THAT(Vec<2>(shapes[1].p_W.head<2>()), IsNear(Vec<2>(-5, 4), 1e-15));
  EXPECT_EQ(shapes[1].size[0], 0.5);
  EXPECT_EQ(shapes[1].p_W[2], shapes[1].size[1] / 2) << "stands on the ground";
}

TEST(ObstacleDetectorTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<ObstacleDetector>({.obstacles = {{{1, 2}, 1}, {{1, 2}, 0}}}, "obstacles.1"));
  EXPECT_TRUE(Refuses<ObstacleDetector>({.obstacles = {{{NAN, 2}, 1}}}, "obstacles.0"));
}

TEST(ObstacleDetectorTest, LooksFartherInARun) {
  TestRig<ObstacleDetector> rig(kParams);
  LeggedState state;
  state.p_WB = {1, 0.7, 0.4};
  rig.Fix(rig->state, state);
  EXPECT_FALSE(rig[rig->obstacle]);
  rig.Set(rig->range, 2);
  EXPECT_FALSE(rig[rig->obstacle]);
  rig.Set(rig->half_width, 0.6);
  EXPECT_TRUE(rig[rig->obstacle]);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->range, 0); }, "range"));
}

}  // namespace tenon::obstacle_detector_test
