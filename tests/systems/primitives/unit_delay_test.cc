#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::unit_delay_test {

TEST(UnitDelayTest, DelaysByOneSample) {
  TestRig<UnitDelay<>> rig({.initial = -1, .rate = Hz(100)});
  EXPECT_EQ(rig.Fix(rig->u, 1).Tick()[rig->y], -1);
  EXPECT_EQ(rig.Fix(rig->u, 2).Tick()[rig->y], 1);
  EXPECT_EQ(rig.Fix(rig->u, 3).Tick()[rig->y], 2);
  EXPECT_EQ(rig.time(), 0.02);
}

TEST(UnitDelayTest, CarriesAnything) {
  TestRig<UnitDelay<std::string>> rig({.initial = "none"});
  EXPECT_EQ(rig[rig->y], "none");
  EXPECT_EQ(rig.Fix(rig->u, "stance").Tick()[rig->y], "none");
  EXPECT_EQ(rig.Tick()[rig->y], "stance");
}

/// y[n + 1] = y[n] + 1, once without and once with the delay that the error message asks for.
TEST(UnitDelayTest, BreaksLoopsOfSampledBlocks) {
  const auto count = [](bool delayed) {
    DiagramBuilder builder;
    auto& one = builder.Add<ConstantSource<>>("one", {.value = 1});
    auto& sum = builder.Add<Adder<>>("sum");
    auto& hold = builder.Add<ZeroOrderHold<>>("hold", {.rate = Hz(10)});
    builder.Connect(one.y, sum.u[0]);
    builder.Connect(sum.y, hold.u);
    if (delayed) {
      auto& delay = builder.Add<UnitDelay<>>("delay", {.rate = Hz(10)});
      builder.Connect(hold.y, delay.u);
      builder.Connect(delay.y, sum.u[1]);
    } else {
      builder.Connect(hold.y, sum.u[1]);
    }
    Simulator simulator(builder.Build());
    simulator.RunTo(1);
    return simulator.context().Eval(hold.y);
  };
  EXPECT_TRUE(Throws<BuildError>([&] { count(false); }, "UnitDelay"));
  EXPECT_EQ(count(true), 11);
}

}  // namespace tenon::unit_delay_test
