#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::zero_order_hold_test {

TEST(ZeroOrderHoldTest, SamplesAFunctionOfTime) {
  DiagramBuilder builder;
  auto& ramp = builder.AddFunction("ramp", Uses(builder.time), [](double t) { return t; });
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", {.rate = Hz(4)});
  builder.Connect(ramp, hold.u);
  Simulator simulator(builder.Build());
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
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "hold.y"));
}

}  // namespace tenon::zero_order_hold_test
