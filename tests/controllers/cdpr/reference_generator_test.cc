#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::reference_generator_test {

TEST(ReferenceGeneratorTest, PlaysThePathAtItsRateAndHoldsItBetween) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1.005);
  EXPECT_THAT(rig[rig->reference].position, IsNear(Eigen::Vector3d(0.2, 0, 2), 1e-12));
  EXPECT_THAT(rig[rig->reference].tension, IsNear(path->At(1).tension, 1e-12));
  rig.Tick();
  EXPECT_THAT(rig[rig->reference].position, IsNear(path->At(1.01).position, 1e-12));
}

TEST(ReferenceGeneratorTest, ShowsWhereTheRobotShouldBe) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1);
  const Geometry& geometry = rig[rig->geometry];
  ASSERT_EQ(geometry.size(), 1);
  EXPECT_EQ(geometry[0].kind, ShapeKind::kTrace);
  EXPECT_EQ(geometry[0].role, ShapeRole::kReference);
  EXPECT_THAT(geometry[0].p_W, IsNear(Vec<3>(0.2, 0, 2), 1e-12));
}

TEST(ReferenceGeneratorTest, NeedsAPath) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<ReferenceGenerator> rig; }, "path"));
}

class GoalPathTest : public testing::Test {
 protected:
  const CdprDescription robot_ = LoadCdpr(FindResource("robots", "cdpr_4"));
  const std::shared_ptr<const EquilibriumPath> circle_ =
      std::make_shared<EquilibriumPath>(robot_, Path::Circle({0, 0, 2}, 0.5, 10, 2));
  TestRig<GoalPath> rig_{GoalPathParams{.path = circle_}};
};

TEST_F(GoalPathTest, WithoutAGoalIsThePlannedOne) {
  EXPECT_EQ(rig_[rig_->path].path, circle_);
}

TEST_F(GoalPathTest, GoesOnFromTheMotionThatTheReferenceHadAndEndsAtTheEquilibriumThere) {
  const Vec<3> place(-0.3, 0.4, 2.2);
  const CdprReference before = circle_->At(4.001);
  rig_.Set(rig_->goal, rig_->GoalAt(place, 4.001, before));
  const EquilibriumPath& path = *rig_[rig_->path].path;
  CdprReference at = path.At(4.001);
  EXPECT_THAT(at.position, IsNear(before.position, 1e-12));
  EXPECT_THAT(at.velocity, IsNear(before.velocity, 1e-12));
  EXPECT_THAT(at.acceleration, IsNear(before.acceleration, 1e-12));
  EXPECT_THAT(at.euler, IsNear(before.euler, 1e-6));
  EXPECT_THAT(at.euler_rate, IsNear(before.euler_rate, 2e-3));
  EXPECT_THAT(at.tension, IsNear(before.tension, 1e-3));
  double fastest = 0;
  for (double t = 4.001; t < path.path().end_time(); t += 0.01)
    fastest = std::max(fastest, path.At(t).velocity.norm());
  EXPECT_LE(fastest, 1.3 * rig_->params.speed);
  at = path.At(100);
  EXPECT_THAT(at.position, IsNear(place, 1e-12));
  EXPECT_THAT(at.velocity, IsNear(Vec<3>::Zero(), 1e-12));
  EXPECT_THAT(at.euler, IsNear(SolveInverseGeometricoStatic(robot_, place).euler, 1e-6));
}

TEST_F(GoalPathTest, APrescribedAttitudeStays) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_8"));
  const Eigen::Vector3d attitude(0, 0, 0.1);
  const auto path = std::make_shared<EquilibriumPath>(robot, Path::Line({0, 0, 1.5}, {0.2, 0, 1.5}, 2),
                                                      StaticsOptions{.attitude = attitude});
  TestRig<GoalPath> rig(GoalPathParams{.path = path});
  rig.Set(rig->goal, rig->GoalAt({0, 0.2, 1.6}, 1, path->At(1)));
  for (const double time : {1.0, 1.4, 9.0})
    EXPECT_THAT(rig[rig->path].path->At(time).euler, IsNear(attitude, 1e-9)) << time;
}

TEST_F(GoalPathTest, APlaceThatNoPathLeadsToIsRefused) {
  EXPECT_TRUE(Throws<ParameterError>([&] { rig_->GoalAt({0, 0, 50}, 1, circle_->At(1)); }, "cdpr_4"));
}

TEST_F(GoalPathTest, RefusesNonsense) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<GoalPath> rig; }, "path"));
  EXPECT_TRUE(Refuses<GoalPath>({.path = circle_, .speed = 0}, "speed"));
  EXPECT_TRUE(Refuses<GoalPath>({.path = circle_, .shortest = -1}, "shortest"));
}

}  // namespace tenon::reference_generator_test
