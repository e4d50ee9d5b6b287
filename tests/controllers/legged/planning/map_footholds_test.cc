#include <tenon/controllers/legged/planning/map_footholds.h>
#include <tenon/tests/controllers/legged/planning/test_map.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::map_footholds_test {

const MapFootholdProperties kChoice;

/// A step of 0.12 m, up along x, between the cells at 0 and 0.03.
ElevationMap Step() {
  return test::MapOf([](double x, double) { return x > 0.015 ? 0.12 : 0.0; });
}

TEST(MapFootholdsTest, FlatGroundIsLeftAlone) {
  const ElevationMap map = test::MapOf([](double, double) { return 0.2; });
  const MapPlace place = FlatPlace(map, {0.101, -0.05}, std::nullopt, kChoice);
  EXPECT_EQ(place.position, Eigen::Vector2d(0.101, -0.05));
  EXPECT_NEAR(place.height, 0.2, 1e-12);
  EXPECT_NEAR(place.deviation, 0, 1e-12);
}

// The ground around a foothold spans two cells to each side: the nearest flat places are the third cell
// before the edge and the third one behind it.
TEST(MapFootholdsTest, AFootholdOnAnEdgeMovesToTheNearerSide) {
  const ElevationMap map = Step();
  const MapPlace below = FlatPlace(map, {0, 0.3}, std::nullopt, kChoice);
  EXPECT_THAT(below.position, IsNear(Eigen::Vector2d(-0.06, 0.3), 1e-12));
  EXPECT_NEAR(below.height, 0, 1e-12);
  const MapPlace above = FlatPlace(map, {0.03, 0.3}, std::nullopt, kChoice);
  EXPECT_THAT(above.position, IsNear(Eigen::Vector2d(0.09, 0.3), 1e-12));
  EXPECT_NEAR(above.height, 0.12, 1e-12);
}

TEST(MapFootholdsTest, AFootholdKeepsItsRadiusFromAnEdgeWhereverTheCellsAre) {
  for (const double edge : {0.0, 0.004, 0.011, 0.016, 0.022, 0.029}) {
    const ElevationMap map = test::MapOf([&](double x, double) { return x > edge ? 0.12 : 0.0; });
    for (double x = -0.06; x < 0.09; x += 0.007) {
      const MapPlace place = FlatPlace(map, {x, 0.1}, std::nullopt, kChoice);
      EXPECT_GE(std::abs(place.position[0] - edge), kChoice.radius) << "edge at " << edge << ", x = " << x;
    }
  }
}

TEST(MapFootholdsTest, AFootInTheAirKeepsItsLevel) {
  const ElevationMap map = Step();
  EXPECT_NEAR(FlatPlace(map, {0, 0.3}, 0.12, kChoice).position[0], 0.09, 1e-12);
  EXPECT_NEAR(FlatPlace(map, {0.03, 0.3}, 0.0, kChoice).position[0], -0.06, 1e-12);
  EXPECT_NEAR(FlatPlace(map, {-0.5, 0}, 0.12, kChoice).height, 0, 1e-12) << "out of reach";
}

TEST(MapFootholdsTest, AFootholdIsFreeOfTheOtherFeet) {
  const ElevationMap map = Step();
  for (const double x : {-0.3, -0.04, 0.0, 0.03, 0.4}) {
    const Eigen::Vector2d alone = FlatPlace(map, {x, 0.3}, std::nullopt, kChoice).position;
    const std::array<Vec<3>, 2> others = {Vec<3>(alone[0], alone[1] + 0.02, 0), Vec<3>(x + 0.1, 0.2, 0.12)};
    const Eigen::Vector2d free = FlatPlace(map, {x, 0.3}, std::nullopt, kChoice, others).position;
    for (const Vec<3>& other : others) EXPECT_GE((free - other.head<2>()).norm(), kChoice.clear) << x;
    const std::array<Vec<3>, 1> far = {Vec<3>(alone[0], alone[1] + kChoice.clear + 1e-9, 0)};
    EXPECT_EQ(FlatPlace(map, {x, 0.3}, std::nullopt, kChoice, far).position, alone);
  }
}

TEST(MapFootholdsTest, KnowsTheHighestPointOfTheWay) {
  const ElevationMap map = test::MapOf([](double x, double) { return std::abs(x) < 0.02 ? 0.3 : -x; });
  EXPECT_NEAR(HighestBetween(map, {-0.2, 0.1}, {0.2, -0.1}), 0.3, 1e-12);
  EXPECT_NEAR(HighestBetween(map, {0.09, 0}, {0.3, 0}), -0.09, 1e-12);
}

TEST(MapFootholdsTest, DoesNotAllocate) {
  const ElevationMap map = Step();
  const AllocationGuard guard;
  for (const double x : {-0.2, 0.0, 0.03, 0.2}) {
    FlatPlace(map, {x, 0.3}, std::nullopt, kChoice);
    FlatPlace(map, {x, 0.3}, 0.1, kChoice);
  }
  EXPECT_EQ(guard.count(), 0);
}

}  // namespace tenon::map_footholds_test
