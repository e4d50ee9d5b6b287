#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/discrete_low_pass.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>

namespace tenon::discrete_low_pass_test {
namespace {

TEST(DiscreteLowPassTest, StepResponse) {
  TestRig<DiscreteLowPass<>> rig(DiscreteLowPassParams<>{.time_constant = 0.3, .initial = 1, .rate = Hz(10)});
  rig.Fix(rig.system().u, 3);
  for (int n = 0; n < 20; ++n) {
    rig.Tick();
    EXPECT_NEAR(rig[rig.system().y], 3 - 2 * std::exp(-rig.time() / 0.3), 1e-14);
  }
}

TEST(DiscreteLowPassTest, EqualsTheContinuousFilterForHeldInputs) {
  DiagramBuilder builder;
  auto& wave = builder.AddFunction("wave", Uses(builder.time), [](double t) { return std::sin(5 * t); });
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", ZeroOrderHoldParams{.rate = Hz(20)});
  auto& continuous = builder.Add<LowPassFilter<>>("continuous", LowPassFilterParams<>{.time_constant = 0.2});
  auto& discrete = builder.Add<DiscreteLowPass<>>(
      "discrete", DiscreteLowPassParams<>{.time_constant = 0.2, .rate = Hz(20)});
  builder.Connect(wave, hold.u);
  builder.Connect(hold.y, continuous.u);
  builder.Connect(hold.y, discrete.u);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 5, .rtol = 1e-11, .atol = 1e-13});
  simulator.RunTo(3);
  EXPECT_NEAR(simulator.context().Eval(discrete.y), simulator.context().Eval(continuous.y), 1e-10);
}

TEST(DiscreteLowPassTest, BreaksLoops) {
  DiagramBuilder builder;
  auto& filter = builder.Add<DiscreteLowPass<Vec<2>>>("filter");
  auto& gain = builder.Add<Gain<Vec<2>>>("gain");
  builder.Connect(filter.y, gain.u);
  builder.Connect(gain.y, filter.u);
  EXPECT_NO_THROW(builder.Build());
}

TEST(DiscreteLowPassTest, DoesNotAllocate) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  TestRig<DiscreteLowPass<Vec<2>>> rig;
  rig.Fix(rig.system().u, {1, 2}).Tick();
  const AllocationGuard guard;
  for (int i = 0; i < 10; ++i) rig.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(DiscreteLowPassTest, RefusesBadParameters) {
  using Params = DiscreteLowPassParams<>;
  EXPECT_TRUE(
      Throws<ParameterError>([] { DiscreteLowPass<> filter(Params{.time_constant = 0}); }, "time_constant"));
  EXPECT_TRUE(
      Throws<ParameterError>([] { DiscreteLowPass<> filter(Params{.initial = std::nan("")}); }, "initial"));
}

TEST(DiscreteLowPassTest, TheTimeConstantIsSetInARun) {
  TestRig<DiscreteLowPass<>> rig({.time_constant = 1e6, .rate = Hz(10), .unit = "m"});
  rig.Set(rig->time_constant, 0.1).Fix(rig->u, 1).Tick().Tick();
  EXPECT_NEAR(rig[rig->y], 1 - std::exp(-1), 1e-15);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->time_constant, 0); }, "'block.time_constant'", "positive"));
}

}  // namespace
}  // namespace tenon::discrete_low_pass_test
