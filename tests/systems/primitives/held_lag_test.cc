#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/primitives/held_lag.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::held_lag_test {

TEST(HeldLagTest, AStepIsAnExponential) {
  constexpr double kLag = 0.004;
  TestRig<HeldLag<>> rig({.time_constant = kLag, .initial = 1});
  rig.Fix(rig->u, 3);
  for (const double time : {0.0004, 0.001, 0.0035, 0.02}) {
    rig.RunTo(time);
    EXPECT_NEAR(rig[rig->y], 3 - 2 * std::exp(-time / kLag), 1e-12) << time << " s";
  }
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

TEST(HeldLagTest, CarriesVectorsAndChangesInARun) {
  TestRig<HeldLag<Vec<2>>> rig({.time_constant = 1});
  rig.Fix(rig->u, {1, -1}).Set(rig->time_constant, 0.01).RunTo(0.01);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>((1 - std::exp(-1)) * Vec<2>(1, -1)), 1e-12));
}

TEST(HeldLagTest, LagsByItsBandwidth) {
  EXPECT_NEAR(LagOfBandwidth(40), 0.00398, 1e-5);
}

TEST(HeldLagTest, RefusesALagOfNothing) {
  EXPECT_TRUE(Refuses<HeldLag<>>({.time_constant = 0}, "time_constant"));
}

}  // namespace tenon::held_lag_test
