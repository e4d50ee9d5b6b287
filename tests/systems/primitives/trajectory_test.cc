#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/trajectory.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>

namespace tenon::trajectory_test {
namespace {

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
    EXPECT_THAT(rig[rig.system().y], IsNear(p(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig.system().dy], IsNear(v(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig.system().ddy], IsNear(a(t), 1e-12)) << t;
  }
}

TEST(TrajectoryTest, IsTwiceContinuouslyDifferentiable) {
  TestRig<Trajectory<>> rig(TrajectoryParams<>{.times = {0, 1, 1.5, 3, 4}, .values = {0, 2, -1, 0.5, 3}});
  auto& block = rig.system();
  for (const double knot : {1.0, 1.5, 3.0}) {
    rig.context().SetTime(knot - 1e-9);
    const double y = rig[block.y], dy = rig[block.dy], ddy = rig[block.ddy];
    rig.context().SetTime(knot + 1e-9);
    EXPECT_NEAR(rig[block.y], y, 1e-6);
    EXPECT_NEAR(rig[block.dy], dy, 1e-6);
    EXPECT_NEAR(rig[block.ddy], ddy, 1e-6);
  }
  rig.context().SetTime(1.5);
  EXPECT_EQ(rig[block.y], -1);
}

TEST(TrajectoryTest, StartsAndEndsAtRest) {
  TestRig<Trajectory<>> rig(TrajectoryParams<>{.times = {1, 3}, .values = {0, 4}});  // 4 (3 r^2 - 2 r^3)
  auto& block = rig.system();
  const double points[][4] = {{0, 0, 0, 0}, {1, 0, 0, 6}, {2, 2, 3, 0}, {3, 4, 0, -6}, {5, 4, 0, 0}};
  for (const auto& [t, y, dy, ddy] : points) {
    rig.RunTo(t);
    EXPECT_NEAR(rig[block.y], y, 1e-14) << t;
    EXPECT_NEAR(rig[block.dy], dy, 1e-14) << t;
    EXPECT_NEAR(rig[block.ddy], ddy, 1e-14) << t;
  }
}

TEST(TrajectoryTest, CarriesItsUnits) {
  TestRig<Trajectory<Vec<2>>> rig(
      TrajectoryParams<Vec<2>>{.times = {0, 1}, .values = {{0, 0}, {1, 1}}, .unit = "m, rad"});
  EXPECT_EQ(rig.system().y.elements()[1].unit, "rad");
  EXPECT_EQ(rig.system().dy.elements()[0].unit, "m/s");
  EXPECT_EQ(rig.system().ddy.elements()[1].unit, "rad/s^2");
  TestRig<Trajectory<>> plain(TrajectoryParams<>{.times = {0, 1}, .values = {0, 1}});
  EXPECT_EQ(plain.system().dy.elements()[0].unit, "");
}

TEST(TrajectoryTest, RefusesBadPoints) {
  const auto make = [](TrajectoryParams<> params) { Trajectory<> block(std::move(params)); };
  EXPECT_TRUE(Throws<ParameterError>([&] { make({}); }, "two times"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.times = {0}, .values = {0}}); }, "two times"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        make({.times = {0, 1}, .values = {0}});
      },
      "there are 2 times and 1 values"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        make({.times = {0, 2, 1}, .values = {0, 0, 0}});
      },
      "must increase"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        make({.times = {0, 1}, .values = {0, std::nan("")}});
      },
      "finite"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        make({.times = {0, 1}, .values = {0, 1}, .end_velocity = std::nan("")});
      },
      "finite"));
}

}  // namespace
}  // namespace tenon::trajectory_test
