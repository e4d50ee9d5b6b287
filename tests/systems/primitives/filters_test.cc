// Filters of first order, and limits of the rate.

#include <tenon/systems/primitives/discrete_derivative.h>
#include <tenon/systems/primitives/held_lag.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/pid.h>
#include <tenon/systems/primitives/rate_limiter.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::filters_test {

using Params = PidParams<>;

TEST(LowPassFilterTest, StepResponse) {
  TestRig<LowPassFilter<Vec<2>>> rig({.time_constant = 0.5, .initial = {1, 0}});
  rig.Fix(rig->u, {0, 2}).RunTo(0.7);
  const double rest = std::exp(-0.7 / 0.5);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(rest, 2 * (1 - rest)), 1e-9));
}

TEST(LowPassFilterTest, FiltersVectors) {
  TestRig<LowPassFilter<Vec<2>>> rig({.time_constant = 0.25, .unit = "m", .elements = "x, z"});
  EXPECT_THAT(rig.Fix(rig->u, {1, 2}).Derivative(rig->x), IsNear(Vec<2>(4, 8), 0));
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[1], "block.y.z");
}

TEST(DiscreteLowPassTest, StepResponse) {
  TestRig<DiscreteLowPass<>> rig({.time_constant = 0.3, .initial = 1, .rate = Hz(10)});
  rig.Fix(rig->u, 3);
  for (int n = 0; n < 20; ++n) {
    rig.Tick();
    EXPECT_NEAR(rig[rig->y], 3 - 2 * std::exp(-rig.time() / 0.3), 1e-14);
  }
}

TEST(DiscreteLowPassTest, EqualsTheContinuousFilterForHeldInputs) {
  DiagramBuilder builder;
  auto& wave = builder.AddFunction("wave", Uses(builder.time), [](double t) { return std::sin(5 * t); });
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", {.rate = Hz(20)});
  auto& continuous = builder.Add<LowPassFilter<>>("continuous", {.time_constant = 0.2});
  auto& discrete = builder.Add<DiscreteLowPass<>>("discrete", {.time_constant = 0.2, .rate = Hz(20)});
  builder.Connect(wave, hold.u);
  builder.Connect(hold.y, continuous.u);
  builder.Connect(hold.y, discrete.u);
  Simulator simulator(builder.Build(), {.order = 5, .rtol = 1e-11, .atol = 1e-13});
  simulator.RunTo(3);
  EXPECT_NEAR(simulator.context().Eval(discrete.y), simulator.context().Eval(continuous.y), 1e-10);
}

TEST(FiltersTest, RefuseInitialValuesThatAreNotFinite) {
  EXPECT_TRUE(Refuses<LowPassFilter<>>({.initial = test::kNan}, "initial"));
  EXPECT_TRUE(Refuses<DiscreteLowPass<>>({.initial = test::kNan}, "initial"));
  EXPECT_TRUE(Refuses<RateLimiter<>>({.initial = test::kNan}, "initial"));
}

/// Compares with a zero-order hold and an integrated low-pass filter.
TEST(HeldLagTest, IsTheLowPassOfAHeldSignal) {
  DiagramBuilder builder;
  auto& sine = builder.Add<Sine<>>("sine", {.angular_frequency = 300});
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", {.rate = Hz(1000)});
  auto& filter = builder.Add<LowPassFilter<>>("filter", {.time_constant = 0.002});
  auto& lag = builder.Add<HeldLag<>>("lag", {.time_constant = 0.002});
  builder.Connect(sine.y, hold.u);
  builder.Connect(hold.y, filter.u);
  builder.Connect(sine.y, lag.u);
  Simulator simulator(builder.Build(), SimulatorOptions{.rtol = 1e-10, .atol = 1e-12});
  for (int k = 1; k < 60; ++k) {
    simulator.RunTo(k * 0.00037);
    EXPECT_NEAR(simulator.context().Eval(lag.y), simulator.context().Eval(filter.y), 1e-8) << k;
  }
}

TEST(HeldLagTest, CarriesVectorsFromTheirInitialValueAndChangesInARun) {
  TestRig<HeldLag<Vec<2>>> rig({.time_constant = 1, .initial = {3, 3}});
  rig.Fix(rig->u, {1, -1}).Set(rig->time_constant, 0.01).RunTo(0.01);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1 + 2 / M_E, -1 + 4 / M_E), 1e-12));
}

TEST(HeldLagTest, LagsByItsBandwidth) {
  EXPECT_NEAR(LagOfBandwidth(40), 0.00398, 1e-5);
}

TEST(DiscreteDerivativeTest, DifferencesWithoutFilter) {
  TestRig<DiscreteDerivative<Vec<2>>> rig({.rate = Hz(10), .u_unit = "m", .y_unit = "m/s"});
  EXPECT_THAT(rig.Fix(rig->u, {5, 1}).Tick()[rig->y], IsNear(Vec<2>(0, 0), 0));
  EXPECT_THAT(rig.Fix(rig->u, {6, 1}).Tick()[rig->y], IsNear(Vec<2>(10, 0), 1e-13));
  EXPECT_THAT(rig.Fix(rig->u, {6, 4}).Tick()[rig->y], IsNear(Vec<2>(0, 30), 1e-13));
}

TEST(DiscreteDerivativeTest, FiltersTheDerivativeOfARamp) {
  const double h = 0.01, time_constant = 0.03;
  TestRig<DiscreteDerivative<>> rig({.time_constant = time_constant, .rate = Hz(100)});
  for (int n = 0; n < 30; ++n) {
    rig.Fix(rig->u, 4 + 7 * h * n).Tick();
    EXPECT_NEAR(rig[rig->y], 7 * (1 - std::pow(time_constant / (time_constant + h), n)), 1e-11);
  }
}

TEST(RateLimiterTest, RampsToItsInput) {
  TestRig<RateLimiter<>> rig({.falling = -20, .rising = 10, .rate = Hz(10), .unit = "m"});
  rig.Fix(rig->u, 2.5);
  for (const double y : {1.0, 2.0, 2.5, 2.5}) EXPECT_NEAR(rig.Tick()[rig->y], y, 1e-15);
  rig.Fix(rig->u, -3);
  for (const double y : {0.5, -1.5, -3.0, -3.0}) EXPECT_NEAR(rig.Tick()[rig->y], y, 1e-15);
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

}  // namespace tenon::filters_test
