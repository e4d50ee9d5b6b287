#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::unit_delay_test {
namespace {

TEST(UnitDelayTest, DelaysByOneSample) {
  TestRig<UnitDelay<>> rig(UnitDelayParams<>{.initial = -1, .rate = Hz(100)});
  auto& block = rig.system();
  EXPECT_EQ(rig.Fix(block.u, 1).Tick()[block.y], -1);
  EXPECT_EQ(rig.Fix(block.u, 2).Tick()[block.y], 1);
  EXPECT_EQ(rig.Fix(block.u, 3).Tick()[block.y], 2);
  EXPECT_EQ(rig.time(), 0.02);
}

TEST(UnitDelayTest, CarriesAnything) {
  TestRig<UnitDelay<std::string>> rig(UnitDelayParams<std::string>{.initial = "none"});
  auto& block = rig.system();
  EXPECT_EQ(rig[block.y], "none");
  EXPECT_EQ(rig.Fix(block.u, "stance").Tick()[block.y], "none");
  EXPECT_EQ(rig.Tick()[block.y], "stance");
}

/// y[n + 1] = y[n] + 1, once without and once with the delay that the error message asks for.
TEST(UnitDelayTest, BreaksLoopsOfSampledBlocks) {
  const auto count = [](bool delayed) {
    DiagramBuilder builder;
    auto& one = builder.Add<ConstantSource<>>("one", ConstantParams<>{.value = 1});
    auto& sum = builder.Add<Adder<>>("sum");
    auto& hold = builder.Add<ZeroOrderHold<>>("hold", ZeroOrderHoldParams{.rate = Hz(10)});
    builder.Connect(one.y, sum.u[0]);
    builder.Connect(sum.y, hold.u);
    if (delayed) {
      auto& delay = builder.Add<UnitDelay<>>("delay", UnitDelayParams<>{.rate = Hz(10)});
      builder.Connect(hold.y, delay.u);
      builder.Connect(delay.y, sum.u[1]);
    } else {
      builder.Connect(hold.y, sum.u[1]);
    }
    const auto diagram = builder.Build();
    Simulator simulator(*diagram);
    simulator.RunTo(1);
    return simulator.context().Eval(hold.y);
  };
  EXPECT_TRUE(Throws<BuildError>([&] { count(false); }, "algebraic loop", "UnitDelay"));
  EXPECT_EQ(count(true), 11);
}

}  // namespace
}  // namespace tenon::unit_delay_test
