#include <tenon/systems/primitives/discrete_derivative.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::discrete_derivative_test {

using Params = DiscreteDerivativeParams;

TEST(DiscreteDerivativeTest, DifferencesWithoutFilter) {
  TestRig<DiscreteDerivative<Vec<2>>> rig({.rate = Hz(10), .u_unit = "m", .y_unit = "m/s"});
  EXPECT_THAT(rig.Fix(rig->u, {5, 1}).Tick()[rig->y], IsNear(Vec<2>(0, 0), 0));
  EXPECT_THAT(rig.Fix(rig->u, {6, 1}).Tick()[rig->y], IsNear(Vec<2>(10, 0), 1e-13));
  EXPECT_THAT(rig.Fix(rig->u, {6, 4}).Tick()[rig->y], IsNear(Vec<2>(0, 30), 1e-13));
  EXPECT_EQ(rig->y.elements()[0].unit, "m/s");
}

TEST(DiscreteDerivativeTest, FiltersTheDerivativeOfARamp) {
  const double h = 0.01, time_constant = 0.03;
  TestRig<DiscreteDerivative<>> rig({.time_constant = time_constant, .rate = Hz(100)});
  for (int n = 0; n < 30; ++n) {
    rig.Fix(rig->u, 4 + 7 * h * n).Tick();
    EXPECT_NEAR(rig[rig->y], 7 * (1 - std::pow(time_constant / (time_constant + h), n)), 1e-11);
  }
}

TEST(DiscreteDerivativeTest, TheFilterCanBeSetInARun) {
  TestRig<DiscreteDerivative<>> rig({.time_constant = 1e6, .rate = Hz(10)});
  rig.Fix(rig->u, 0).Tick().Set(rig->time_constant, 0).Fix(rig->u, 1).Tick();
  EXPECT_NEAR(rig[rig->y], 10, 1e-13);
}

TEST(DiscreteDerivativeTest, RefusesABadTimeConstant) {
  for (const double bad : {-1.0, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<DiscreteDerivative<>>({.time_constant = bad}, "time_constant"));
}

}  // namespace tenon::discrete_derivative_test
