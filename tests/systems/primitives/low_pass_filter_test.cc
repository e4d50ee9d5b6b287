#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::low_pass_filter_test {

TEST(LowPassFilterTest, StepResponse) {
  TestRig<LowPassFilter<Vec<2>>> rig({.time_constant = 0.5, .initial = {1, 0}});
  rig.Fix(rig->u, {0, 2}).RunTo(0.7);
  const double rest = std::exp(-0.7 / 0.5);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(rest, 2 * (1 - rest)), 1e-9));
}

TEST(LowPassFilterTest, BreaksLoops) {
  DiagramBuilder builder;
  auto& filter = builder.Add<LowPassFilter<>>("filter", {.time_constant = 1, .initial = 1});
  auto& gain = builder.Add<Gain<>>("gain", {.gain = -1});
  builder.Connect(filter.y, gain.u);
  builder.Connect(gain.y, filter.u);
  Simulator simulator(builder.Build(), {.order = 5, .rtol = 1e-10, .atol = 1e-12});
  simulator.RunTo(1);
  EXPECT_NEAR(simulator.context().Eval(filter.y), std::exp(-2), 1e-8);
}

TEST(LowPassFilterTest, RefusesBadParameters) {
  for (const double bad : {0.0, -1.0, test::kNan})
    EXPECT_TRUE(Refuses<LowPassFilter<>>({.time_constant = bad}, "time_constant"));
  EXPECT_TRUE(Refuses<LowPassFilter<>>({.initial = test::kNan}, "initial"));
}

TEST(LowPassFilterTest, TheTimeConstantIsSetInARun) {
  TestRig<LowPassFilter<Vec<2>>> rig({.time_constant = 0.5, .unit = "m", .elements = "x, z"});
  rig.Set(rig->time_constant, 0.25);
  EXPECT_THAT(rig.Fix(rig->u, {1, 2}).Derivative(rig->x), IsNear(Vec<2>(4, 8), 0));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->time_constant, 0); }, "'block.time_constant'", "above 0"));
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[1], "block.y.z");
}

}  // namespace tenon::low_pass_filter_test
