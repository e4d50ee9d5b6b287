#include <tenon/plants/sensors/terrain_mapper.h>
#include <tenon/plants/signals/quaternion.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::terrain_mapper_test {

TerrainMapperParams Params(double noise) {
  return {.terrain = {.stairs = Stairs{.rise = 0.1, .steps = 1}}, .map = {.noise = noise}};
}

ElevationMap MapOf(const TerrainMapperParams& params, const LeggedState& state, const LeggedState& told) {
  TestRig<TerrainMapper> rig(params);
  rig.Fix(rig->state, state).Fix(rig->told, told).Tick();
  return rig[rig->map];
}

TEST(TerrainMapperTest, ShowsTheKerbWhereItIs) {
  LeggedState state;
  state.p_WB << 0.9, 0.2, 0.5;
  const ElevationMap map = MapOf(Params(0), state, state);
  EXPECT_EQ(map.HeightAt({0.97, 0}), 0);
  EXPECT_NEAR(map.HeightAt({1.03, 0}), 0.1, 1e-12);
  EXPECT_NEAR(map.HeightAt({1.7, -0.6}), 0.1, 1e-12);
}

// A robot that believes to be further ahead, higher and turned sees the kerb in its own axes.
TEST(TerrainMapperTest, MovesWithTheErrorOfTheState) {
  LeggedState state, told;
  state.p_WB << 0.9, 0, 0.5;
  told.p_WB << 1.4, 0.3, 0.7;
  told.q_WB = QuaternionFromRotationVector({0, 0, M_PI / 2});
  const ElevationMap map = MapOf(Params(0), state, told);  // ahead is now y
  EXPECT_NEAR(map.HeightAt({1.4, 0.3 + 0.05}), 0.2, 1e-12);
  EXPECT_NEAR(map.HeightAt({1.4, 0.3 + 0.15}), 0.3, 1e-12);
}

TEST(TerrainMapperTest, NoiseBelongsToThePlace) {
  LeggedState state;
  state.p_WB << -5, 3, 0.5;
  const ElevationMap before = MapOf(Params(0.01), state, state);
  state.p_WB[0] += 0.3;
  const ElevationMap after = MapOf(Params(0.01), state, state);
  double squares = 0;
  for (const double h : before.height) squares += h * h;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(before.height.size())), 0.01, 5e-4);
  for (const double x : {-5.2, -5.0, -4.5})
    EXPECT_EQ(before.HeightAt({x, 3.1}), after.HeightAt({x, 3.1})) << x;
  TerrainMapperParams other = Params(0.01);
  other.seed = 2;
  EXPECT_NE(MapOf(other, state, state).HeightAt({-5, 3}), after.HeightAt({-5, 3}));
}

}  // namespace tenon::terrain_mapper_test
