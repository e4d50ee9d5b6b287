#include <tenon/systems/primitives/discrete_low_pass.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::discrete_low_pass_test {

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

TEST(DiscreteLowPassTest, RefusesBadParameters) {
  EXPECT_TRUE(Refuses<DiscreteLowPass<>>({.time_constant = 0}, "time_constant"));
  EXPECT_TRUE(Refuses<DiscreteLowPass<>>({.initial = test::kNan}, "initial"));
}

TEST(DiscreteLowPassTest, TheTimeConstantIsSetInARun) {
  TestRig<DiscreteLowPass<>> rig({.time_constant = 1e6, .rate = Hz(10), .unit = "m"});
  rig.Set(rig->time_constant, 0.1).Fix(rig->u, 1).Tick().Tick();
  EXPECT_NEAR(rig[rig->y], 1 - std::exp(-1), 1e-15);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->time_constant, 0); }, "'block.time_constant'", "above 0"));
}

}  // namespace tenon::discrete_low_pass_test
