#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/saturation.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>

namespace tenon::saturation_test {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(SaturationTest, Limits) {
  TestRig<Saturation<>> rig(SaturationParams<>{.lower = -1, .upper = 2});
  auto& block = rig.system();
  EXPECT_EQ(rig.Fix(block.u, -5)[block.y], -1);
  EXPECT_EQ(rig.Fix(block.u, 0.5)[block.y], 0.5);
  EXPECT_EQ(rig.Fix(block.u, 5)[block.y], 2);
}

TEST(SaturationTest, IsOpenByDefault) {
  TestRig<Saturation<>> rig(SaturationParams<>{.upper = 2});
  auto& block = rig.system();
  EXPECT_EQ(rig.Fix(block.u, -1e300)[block.y], -1e300);
  EXPECT_EQ(rig.Fix(block.u, 1e300)[block.y], 2);
}

TEST(SaturationTest, LimitsElementByElement) {
  TestRig<Saturation<Vec<2>>> rig(SaturationParams<Vec<2>>{.lower = {-1, -10}, .upper = {1, 10}});
  EXPECT_THAT(rig.Fix(rig.system().u, {5, 5})[rig.system().y], IsNear(Vec<2>(1, 5), 0));
  EXPECT_THAT(rig.Fix(rig.system().u, {-5, -50})[rig.system().y], IsNear(Vec<2>(-1, -10), 0));
}

TEST(SaturationTest, DoesNotHideNan) {
  TestRig<Saturation<>> rig(SaturationParams<>{.lower = -1, .upper = 2});
  EXPECT_TRUE(std::isnan(rig.Fix(rig.system().u, kNan)[rig.system().y]));
}

TEST(SaturationTest, RefusesCrossedLimits) {
  EXPECT_TRUE(Throws<ParameterError>([] { Saturation<> block(SaturationParams<>{.lower = 1, .upper = 0}); },
                                     "lower must not exceed upper"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        Saturation<Vec<2>> block(SaturationParams<Vec<2>>{.lower = {0, 3}, .upper = {1, 2}});
      },
      "element"));
  EXPECT_TRUE(Throws<ParameterError>([] { Saturation<> block(SaturationParams<>{.upper = kNan}); }, "lower"));
}

TEST(SaturationTest, LimitsAreSetInARun) {
  TestRig<Saturation<>> rig({.lower = -1, .upper = 2});
  rig.Set(rig->upper, 3);
  EXPECT_EQ(rig.Fix(rig->u, 5)[rig->y], 3);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->upper, -3); }, "'block.upper'", "lower must not exceed"));
}

}  // namespace
}  // namespace tenon::saturation_test
