#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::zero_order_hold_test {
namespace {

TEST(ZeroOrderHoldTest, HoldsBetweenTicks) {
  TestRig<ZeroOrderHold<>> rig(ZeroOrderHoldParams{.rate = Hz(10)});
  auto& block = rig.system();
  EXPECT_EQ(rig.Fix(block.u, 1).Tick()[block.y], 1);
  EXPECT_EQ(rig.Fix(block.u, 2).RunTo(0.09)[block.y], 1);
  EXPECT_EQ(rig.RunTo(0.1)[block.y], 2);
}

TEST(ZeroOrderHoldTest, SamplesAFunctionOfTime) {
  DiagramBuilder builder;
  auto& ramp = builder.AddFunction("ramp", Uses(builder.time), [](double t) { return t; });
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", ZeroOrderHoldParams{.rate = Hz(4)});
  builder.Connect(ramp, hold.u);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  for (const double t : {0.0, 0.1, 0.25, 0.4, 0.99}) {
    simulator.RunTo(t);
    EXPECT_EQ(simulator.context().Eval(hold.y), std::floor(t * 4) / 4);
  }
}

TEST(ZeroOrderHoldTest, HasFeedthrough) {
  DiagramBuilder builder;
  auto& hold = builder.Add<ZeroOrderHold<>>("hold");
  auto& gain = builder.Add<Gain<>>("gain");
  builder.Connect(hold.y, gain.u);
  builder.Connect(gain.y, hold.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "algebraic loop", "hold.y"));
}

}  // namespace
}  // namespace tenon::zero_order_hold_test
