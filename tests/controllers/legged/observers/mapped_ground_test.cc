#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/plants/signals/quaternion.h>
#include <tenon/tests/controllers/legged/planning/test_map.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::mapped_ground_test {
namespace {

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

}  // namespace
}  // namespace tenon::mapped_ground_test
