#include <tenon/systems/primitives/saturation.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::saturation_test {

TEST(SaturationTest, IsOpenByDefault) {
  TestRig<Saturation<>> rig({.upper = 2});
  EXPECT_EQ(rig.Fix(rig->u, -1e300)[rig->y], -1e300);
  EXPECT_EQ(rig.Fix(rig->u, 1e300)[rig->y], 2);
}

TEST(SaturationTest, LimitsElementByElement) {
  TestRig<Saturation<Vec<2>>> rig({.lower = {-1, -10}, .upper = {1, 10}});
  EXPECT_THAT(rig.Fix(rig->u, {5, 5})[rig->y], IsNear(Vec<2>(1, 5), 0));
  EXPECT_THAT(rig.Fix(rig->u, {-5, -50})[rig->y], IsNear(Vec<2>(-1, -10), 0));
}

TEST(SaturationTest, AnyElementChangesThePiece) {
  TestRig<Saturation<Vec<3>>> rig({.lower = Vec<3>(-1, -1, -1), .upper = Vec<3>(1, 1, 1)});
  const std::int64_t inside = rig.Fix(rig->u, Vec<3>(0, 0, 0))[rig->kink];
  for (int i = 0; i < 3; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const Vec<3> outside = 2 * side * Vec<3>::Unit(i);
      EXPECT_NE(rig.Fix(rig->u, outside)[rig->kink], inside) << i << ' ' << side;
    }
  }
}

TEST(SaturationTest, DoesNotHideNan) {
  TestRig<Saturation<>> rig({.lower = -1, .upper = 2});
  EXPECT_TRUE(std::isnan(rig.Fix(rig->u, test::kNan)[rig->y]));
}

TEST(SaturationTest, RefusesCrossedLimits) {
  EXPECT_TRUE(Refuses<Saturation<>>({.lower = 1, .upper = 0}, "lower"));
  EXPECT_TRUE(Refuses<Saturation<Vec<2>>>({.lower = {0, 3}, .upper = {1, 2}}, "upper"));
  EXPECT_TRUE(Refuses<Saturation<>>({.upper = test::kNan}, "lower"));
}

TEST(SaturationTest, LimitsAreSetInARun) {
  TestRig<Saturation<>> rig({.lower = -1, .upper = 2});
  rig.Set(rig->upper, 3);
  EXPECT_EQ(rig.Fix(rig->u, 5)[rig->y], 3);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->upper, -3); }, "'block.upper'"));
}

}  // namespace tenon::saturation_test
