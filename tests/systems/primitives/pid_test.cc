#include <tenon/systems/primitives/pid.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::pid_test {

using Params = PidParams<>;

TEST(PidTest, IntegralIsTheSumOfErrors) {
  TestRig<Pid<>> rig({.kp = 2, .ki = 5, .rate = Hz(10)});
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
  TestRig<Pid<>> rig({.kp = 0, .kd = 1, .filter_time = 0});
  EXPECT_EQ(rig.Fix(rig->ref, 100).Fix(rig->y, 3).Tick()[rig->u], 0);
}

TEST(PidTest, StopsIntegratingBeyondItsLimits) {
  TestRig<Pid<>> rig({.kp = 1, .ki = 10, .lower = -2, .upper = 3, .rate = Hz(10)});
  rig.Fix(rig->ref, 1).Fix(rig->y, 0);
  // v = 1, 2, 3, 4: the integral grows up to the limit and not beyond.
  for (const double u : {1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0}) EXPECT_NEAR(rig.Tick()[rig->u], u, 1e-14);
  EXPECT_NEAR(rig[rig->memory].integral, 3, 1e-14);
  // An error of the other sign acts at once: v = -1 + 3, and the integral decreases.
  rig.Fix(rig->ref, -1);
  for (const double u : {2.0, 1.0, 0.0, -1.0, -2.0, -2.0, -2.0}) EXPECT_NEAR(rig.Tick()[rig->u], u, 1e-14);
}

TEST(PidTest, LimitsAndGainsAreOfEachElement) {
  TestRig<Pid<Vec<2>>> rig({.kp = {1, 10},
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
  TestRig<Pid<>> rig({.kp = 0, .ki = 5, .rate = Hz(10)});
  rig.Fix(rig->ref, 1).Fix(rig->y, 0).Tick().Tick().Tick();
  EXPECT_NEAR(rig[rig->u], 1, 1e-15);
  rig.Set(rig->ki, 20);
  EXPECT_NEAR(rig.Tick()[rig->u], 1.5, 1e-15);  // the integral from before
  EXPECT_NEAR(rig.Tick()[rig->u], 3.5, 1e-15);
}

TEST(PidTest, RefusesBadParameters) {
  EXPECT_TRUE(Refuses<Pid<>>({.lower = 1, .upper = 0}, "lower"));
  TestRig<Pid<>> rig({.lower = -1, .upper = 1});
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->upper, -2); }, "'block.upper'"));
}

}  // namespace tenon::pid_test
