#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::integrator_test {

TEST(IntegratorTest, Integrates) {
  TestRig<Integrator<Vec<2>>> rig({.initial = {1, 2}});
  rig.Fix(rig->u, {3, -4});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Derivative(rig->x), IsNear(Vec<2>(3, -4), 0));
  EXPECT_THAT(rig.RunTo(2)[rig->y], IsNear(Vec<2>(7, -6), 1e-12));
  EXPECT_EQ(rig.diagram().ContinuousStateNames(), (std::vector<std::string>{"block.y.0", "block.y.1"}));
}

TEST(IntegratorTest, BreaksLoops) {
  DiagramBuilder builder;
  auto& integrator = builder.Add<Integrator<>>("integrator", {.initial = 3});
  auto& gain = builder.Add<Gain<>>("gain", {.gain = -2});
  builder.Connect(integrator.y, gain.u);
  builder.Connect(gain.y, integrator.u);
  Simulator simulator(builder.Build(), {.order = 5, .rtol = 1e-10, .atol = 1e-12});
  simulator.RunTo(1);
  EXPECT_NEAR(simulator.context().Eval(integrator.y), 3 * std::exp(-2), 1e-8);
}

TEST(IntegratorTest, RefusesAnInitialValueThatIsNotFinite) {
  EXPECT_TRUE(Refuses<Integrator<>>({.initial = test::kNan}, "initial"));
}

}  // namespace tenon::integrator_test
