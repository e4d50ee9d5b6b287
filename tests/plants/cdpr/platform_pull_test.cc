#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::platform_pull_test {
namespace {

// Turned by 90 degrees about z, x_B points along y_W; the point at x_B = 0.2 m moves by w = 1 rad/s.
TEST(PlatformPullTest, PullsAtItsPointBesideOthers) {
  TestRig<PlatformPull> rig(PlatformPullParams{.stiffness = 100, .damping = 10, .max_force = 50});
  PlatformState platform;
  platform.p_WB = {1, 2, 3};
  platform.q_WB = {std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2};
  platform.w_W = {0, 0, 1};
  rig.Fix(rig->platform, platform);
  rig.Fix(rig->others, {{1, 0, 0}, {0, 0, 0.5}});
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(1, 0, 0), 0));
  rig.Set(rig->grip, {true, {0.2, 0, 0}, {1, 2.2, 3.3}});
  // v = w x arm = (-0.2, 0, 0): F = (0, 0, 30) + (2, 0, 0).
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(3, 0, 30), 1e-12));
  // arm x F = (0, 0.2, 0) x (2, 0, 30) = (6, 0, -0.4)
  EXPECT_THAT(rig[rig->wrench].torque_W, IsNear(Vec<3>(6, 0, 0.1), 1e-12));
  rig.Set(rig->grip, {true, {0, 0, 0}, {1, 2, 30}});
  EXPECT_THAT(rig[rig->wrench].force_W, IsNear(Vec<3>(1, 0, 50), 1e-12));
}

TEST(PlatformPullTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<PlatformPull>({.stiffness = -1}, "-1 N/m"));
}

}  // namespace
}  // namespace tenon::platform_pull_test
