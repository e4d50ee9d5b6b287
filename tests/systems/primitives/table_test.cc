#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/table.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>

namespace tenon::table_test {
namespace {

TEST(TableTest, InterpolatesAndClamps) {
  TestRig<Table<>> rig(TableParams<>{.u = {-1, 0, 2, 3}, .y = {5, 1, 2, -4}});
  auto& block = rig.system();
  const double points[][2] = {{-9, 5}, {-1, 5},   {-0.75, 4}, {0, 1}, {0.5, 1.25},
                              {2, 2},  {2.5, -1}, {3, -4},    {9, -4}};
  for (const auto& [u, y] : points) EXPECT_EQ(rig.Fix(block.u, u)[block.y], y) << "at " << u;
}

TEST(TableTest, TakesTwoPoints) {
  TestRig<Table<>> rig(TableParams<>{.u = {0, 1}, .y = {2, 4}});
  EXPECT_EQ(rig.Fix(rig.system().u, 0.5)[rig.system().y], 3);
}

TEST(TableTest, GivesVectors) {
  TestRig<Table<Vec<2>>> rig(TableParams<Vec<2>>{.u = {0, 1}, .y = {{0, 10}, {1, 20}}});
  EXPECT_THAT(rig.Fix(rig.system().u, 0.25)[rig.system().y], IsNear(Vec<2>(0.25, 12.5), 1e-15));
}

TEST(TableTest, DoesNotHideNan) {
  TestRig<Table<>> rig(TableParams<>{.u = {0, 1}, .y = {2, 4}});
  EXPECT_TRUE(std::isnan(rig.Fix(rig.system().u, std::nan(""))[rig.system().y]));
}

TEST(TableTest, RefusesBadPoints) {
  const auto make = [](TableParams<> params) { Table<> table(std::move(params)); };
  EXPECT_TRUE(Throws<ParameterError>([&] { make({}); }, "two points"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.u = {0}, .y = {0}}); }, "two points"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.u = {0, 1}, .y = {0, 1, 2}}); }, "there are 2 u and 3 y"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.u = {0, 1, 1}, .y = {0, 1, 2}}); }, "must increase"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.u = {0, 1}, .y = {0, std::nan("")}}); }, "finite"));
}

}  // namespace
}  // namespace tenon::table_test
