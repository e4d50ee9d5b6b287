#include <tenon/systems/primitives/rate_limiter.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::rate_limiter_test {

TEST(RateLimiterTest, RampsToItsInput) {
  TestRig<RateLimiter<>> rig({.falling = -20, .rising = 10, .rate = Hz(10), .unit = "m"});
  rig.Fix(rig->u, 2.5);
  for (const double y : {1.0, 2.0, 2.5, 2.5}) EXPECT_NEAR(rig.Tick()[rig->y], y, 1e-15);
  rig.Fix(rig->u, -3);
  for (const double y : {0.5, -1.5, -3.0, -3.0}) EXPECT_NEAR(rig.Tick()[rig->y], y, 1e-15);
  EXPECT_EQ(rig->rising.elements()[0].unit, "m/s");
}

TEST(RateLimiterTest, PassesAllByDefault) {
  TestRig<RateLimiter<>> rig;
  EXPECT_EQ(rig.Fix(rig->u, 1e300).Tick()[rig->y], 1e300);
  EXPECT_EQ(rig.Fix(rig->u, -0.1).Tick()[rig->y], -0.1);
}

TEST(RateLimiterTest, LimitsEachElementFromItsInitialValue) {
  TestRig<RateLimiter<Vec<2>>> rig({.rising = {10, 1}, .initial = {0, 5}, .rate = Hz(10)});
  EXPECT_THAT(rig.Fix(rig->u, {3, 6}).Tick()[rig->y], IsNear(Vec<2>(1, 5.1), 1e-15));
  rig.Set(rig->rising, {0, 100});
  EXPECT_THAT(rig.Tick()[rig->y], IsNear(Vec<2>(1, 6), 1e-15));
}

TEST(RateLimiterTest, DoesNotHideNan) {
  TestRig<RateLimiter<>> rig({.falling = -1, .rising = 1});
  EXPECT_TRUE(Throws<RunError>([&] { rig.Fix(rig->u, test::kNan).Tick(); }, "block"));
}

TEST(RateLimiterTest, RefusesBadLimits) {
  EXPECT_TRUE(Refuses<RateLimiter<>>({.falling = 1}, "falling"));
  EXPECT_TRUE(Refuses<RateLimiter<>>({.rising = -1}, "rising"));
  EXPECT_TRUE(Refuses<RateLimiter<>>({.rising = test::kNan}, "rising"));
  EXPECT_TRUE(Refuses<RateLimiter<>>({.initial = test::kNan}, "initial"));
}

}  // namespace tenon::rate_limiter_test
