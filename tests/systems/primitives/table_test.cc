#include <tenon/systems/primitives/table.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::table_test {

TEST(TableTest, InterpolatesAndClamps) {
  TestRig<Table<>> rig({.u = {-1, 0, 2, 3}, .y = {5, 1, 2, -4}});
  const double points[][2] = {{-9, 5}, {-1, 5},   {-0.75, 4}, {0, 1}, {0.5, 1.25},
                              {2, 2},  {2.5, -1}, {3, -4},    {9, -4}};
  for (const auto& [u, y] : points) EXPECT_EQ(rig.Fix(rig->u, u)[rig->y], y) << "at " << u;
}

TEST(TableTest, GivesVectors) {
  TestRig<Table<Vec<2>>> rig({.u = {0, 1}, .y = {{0, 10}, {1, 20}}});
  EXPECT_THAT(rig.Fix(rig->u, 0.25)[rig->y], IsNear(Vec<2>(0.25, 12.5), 1e-15));
}

TEST(TableTest, DoesNotHideNan) {
  TestRig<Table<>> rig({.u = {0, 1}, .y = {2, 4}});
  EXPECT_TRUE(std::isnan(rig.Fix(rig->u, test::kNan)[rig->y]));
}

TEST(TableTest, RefusesBadPoints) {
  EXPECT_TRUE(Refuses<Table<>>({}, "two points"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0}, .y = {0}}, "two points"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1}, .y = {0, 1, 2}}, "2 u and 3 y"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1, 1}, .y = {0, 1, 2}}, "u must increase"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1}, .y = {0, test::kNan}}, "finite"));
}

}  // namespace tenon::table_test
