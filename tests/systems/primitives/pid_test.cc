#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/pid.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenon::pid_test {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

using Params = PidParams<>;

TEST(PidTest, ProportionalPartAlone) {
  TestRig<Pid<>> rig(Params{.kp = 3});
  EXPECT_EQ(rig.Fix(rig->ref, 2).Fix(rig->y, 0.5).Tick()[rig->u], 4.5);
}

TEST(PidTest, IntegralIsTheSumOfErrors) {
  TestRig<Pid<>> rig(Params{.kp = 2, .ki = 5, .rate = Hz(10)});
  rig.Fix(rig->ref, 1).Fix(rig->y, 0);
  for (int n = 0; n < 20; ++n) EXPECT_NEAR(rig.Tick()[rig->u], 2 + 5 * 0.1 * n, 1e-13) << n;
}

TEST(PidTest, DerivativeOfARampIsFiltered) {
  const double h = 0.01, filter = 0.04, pole = filter / (filter + h);
  for (const double ref_weight : {0.0, 0.5, 1.0}) {
    TestRig<Pid<>> rig(
        Params{.kp = 0, .kd = 2, .filter_time = filter, .ref_weight = ref_weight, .rate = Hz(100)});
    for (int n = 0; n < 30; ++n) {
      rig.Fix(rig->ref, 7 * h * n).Fix(rig->y, -3 * h * n).Tick();
      EXPECT_NEAR(rig[rig->u], 2 * (7 * ref_weight + 3) * (1 - std::pow(pole, n)), 1e-11) << n;
    }
  }
}

TEST(PidTest, DoesNotKickAtTheFirstTick) {
  TestRig<Pid<>> rig(Params{.kp = 0, .kd = 1, .filter_time = 0});
  EXPECT_EQ(rig.Fix(rig->ref, 100).Fix(rig->y, 3).Tick()[rig->u], 0);
}

TEST(PidTest, StopsIntegratingBeyondItsLimits) {
  TestRig<Pid<>> rig(Params{.kp = 1, .ki = 10, .lower = -2, .upper = 3, .rate = Hz(10)});
  rig.Fix(rig->ref, 1).Fix(rig->y, 0);
  // v = 1, 2, 3, 4: at the limit it still integrates, beyond it no more.
  for (const double u : {1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0}) EXPECT_NEAR(rig.Tick()[rig->u], u, 1e-14);
  EXPECT_NEAR(rig[rig->memory].integral, 3, 1e-14);
  // An error the other way is felt at once: v = -1 + 3, and the integral falls.
  rig.Fix(rig->ref, -1);
  for (const double u : {2.0, 1.0, 0.0, -1.0, -2.0, -2.0, -2.0}) EXPECT_NEAR(rig.Tick()[rig->u], u, 1e-14);
}

TEST(PidTest, LimitsAndGainsAreOfEachElement) {
  TestRig<Pid<Vec<2>>> rig(PidParams<Vec<2>>{.kp = {1, 10},
                                             .ki = {0, 1},
                                             .upper = {1, 100},
                                             .rate = Hz(10),
                                             .y_unit = "m, rad",
                                             .elements = "x, pitch"});
  rig.Fix(rig->ref, {2, 2}).Fix(rig->y, {0, 0}).Tick();
  EXPECT_THAT(rig[rig->u], IsNear(Vec<2>(1, 20), 0));
  EXPECT_THAT(rig.Tick()[rig->u], IsNear(Vec<2>(1, 20.2), 1e-13));
  EXPECT_EQ(rig->y.elements()[1].name, "pitch");
  EXPECT_EQ(rig->y.elements()[1].unit, "rad");
}

TEST(PidTest, AGainThatIsSetMakesNoJumpByTheIntegral) {
  TestRig<Pid<>> rig(Params{.kp = 0, .ki = 5, .rate = Hz(10)});
  rig.Fix(rig->ref, 1).Fix(rig->y, 0).Tick().Tick().Tick();
  EXPECT_NEAR(rig[rig->u], 1, 1e-15);
  rig.Set(rig->ki, 20);
  EXPECT_NEAR(rig.Tick()[rig->u], 1.5, 1e-15);  // what was integrated before
  EXPECT_NEAR(rig.Tick()[rig->u], 3.5, 1e-15);
}

TEST(PidTest, DoesNotAllocate) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  TestRig<Pid<Vec<3>>> rig;
  rig.Fix(rig->ref, {1, 2, 3}).Fix(rig->y, {0, 0, 0}).Tick();
  const AllocationGuard guard;
  for (int i = 0; i < 10; ++i) rig.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(PidTest, RefusesBadParameters) {
  const auto make = [](Params params) { Pid<> block(std::move(params)); };
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.ki = kNan}); }, "kp, ki and kd must be finite"));
  for (const double bad : {-1.0, kNan}) {
    EXPECT_TRUE(Throws<ParameterError>([&] { make({.filter_time = bad}); }, "filter_time must be"));
  }
  for (const double bad : {-0.1, 1.1, kNan}) {
    EXPECT_TRUE(Throws<ParameterError>([&] { make({.ref_weight = bad}); }, "ref_weight must be from 0"));
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { make({.lower = 1, .upper = 0}); }, "lower must not exceed upper"));
  TestRig<Pid<>> rig(Params{.lower = -1, .upper = 1});
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->upper, -2); }, "'block.upper'", "lower must not exceed"));
}

}  // namespace
}  // namespace tenon::pid_test
