#include <tenon/systems/primitives/trajectory.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::trajectory_test {

TEST(TrajectoryTest, ReproducesACubic) {
  const auto p = [](double t) -> Vec<2> { return {1 + t * t * t, 2 * t - t * t}; };
  const auto v = [](double t) -> Vec<2> { return {3 * t * t, 2 - 2 * t}; };
  const auto a = [](double t) -> Vec<2> { return {6 * t, -2}; };
  TrajectoryParams<Vec<2>> params{.start_velocity = v(-1), .end_velocity = v(3)};
  for (const double t : {-1.0, 0.0, 0.5, 2.0, 3.0}) {
    params.times.push_back(t);
    params.values.push_back(p(t));
  }
  TestRig<Trajectory<Vec<2>>> rig(params);
  for (const double t : {-1.0, -0.3, 0.0, 0.2, 0.5, 1.7, 2.0, 2.9, 3.0}) {
    rig.context().SetTime(t);
    EXPECT_THAT(rig[rig->y], IsNear(p(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig->dy], IsNear(v(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig->ddy], IsNear(a(t), 1e-12)) << t;
  }
}

TEST(TrajectoryTest, IsTwiceContinuouslyDifferentiable) {
  TestRig<Trajectory<>> rig({.times = {0, 1, 1.5, 3, 4}, .values = {0, 2, -1, 0.5, 3}});
  for (const double knot : {1.0, 1.5, 3.0}) {
    rig.context().SetTime(knot - 1e-9);
    const double y = rig[rig->y], dy = rig[rig->dy], ddy = rig[rig->ddy];
    rig.context().SetTime(knot + 1e-9);
    EXPECT_NEAR(rig[rig->y], y, 1e-6);
    EXPECT_NEAR(rig[rig->dy], dy, 1e-6);
    EXPECT_NEAR(rig[rig->ddy], ddy, 1e-6);
  }
  rig.context().SetTime(1.5);
  EXPECT_EQ(rig[rig->y], -1);
}

TEST(TrajectoryTest, StartsAndEndsAtRest) {
  TestRig<Trajectory<>> rig({.times = {1, 3}, .values = {0, 4}, .unit = "m"});  // 4 (3 r^2 - 2 r^3)
  const double points[][4] = {{0, 0, 0, 0}, {1, 0, 0, 6}, {2, 2, 3, 0}, {3, 4, 0, -6}, {5, 4, 0, 0}};
  for (const auto& [t, y, dy, ddy] : points) {
    rig.RunTo(t);
    EXPECT_NEAR(rig[rig->y], y, 1e-14) << t;
    EXPECT_NEAR(rig[rig->dy], dy, 1e-14) << t;
    EXPECT_NEAR(rig[rig->ddy], ddy, 1e-14) << t;
  }
  EXPECT_EQ(rig->y.elements()[0].unit, "m");
  EXPECT_EQ(rig->dy.elements()[0].unit, "m/s");
  EXPECT_EQ(rig->ddy.elements()[0].unit, "m/s^2");
}

TEST(TrajectoryTest, RefusesBadPoints) {
  EXPECT_TRUE(Refuses<Trajectory<>>({}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0}, .values = {0}}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 1}, .values = {0}}, "values"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 2, 1}, .values = {0, 0, 0}}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 1}, .values = {0, test::kNan}}, "finite"));
  EXPECT_TRUE(
      Refuses<Trajectory<>>({.times = {0, 1}, .values = {0, 1}, .end_velocity = test::kNan}, "finite"));
}

}  // namespace tenon::trajectory_test
