#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenon::integrator_test {
namespace {

TEST(IntegratorTest, Integrates) {
  TestRig<Integrator<Vec<2>>> rig(IntegratorParams<Vec<2>>{.initial = {1, 2}});
  auto& block = rig.system();
  rig.Fix(block.u, {3, -4});
  EXPECT_THAT(rig[block.y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Derivative(block.x), IsNear(Vec<2>(3, -4), 0));
  EXPECT_THAT(rig.RunTo(2)[block.y], IsNear(Vec<2>(7, -6), 1e-12));
}

TEST(IntegratorTest, BreaksLoops) {
  DiagramBuilder builder;
  auto& integrator = builder.Add<Integrator<>>("integrator", IntegratorParams<>{.initial = 3});
  auto& gain = builder.Add<Gain<>>("gain", GainParams{.gain = -2});
  builder.Connect(integrator.y, gain.u);
  builder.Connect(gain.y, integrator.u);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 5, .rtol = 1e-10, .atol = 1e-12});
  simulator.RunTo(1);
  EXPECT_NEAR(simulator.context().Eval(integrator.y), 3 * std::exp(-2), 1e-8);
}

TEST(IntegratorTest, NamesItsState) {
  TestRig<Integrator<Vec<2>>> rig;
  EXPECT_EQ(rig.diagram().ContinuousStateNames(), (std::vector<std::string>{"block.y.0", "block.y.1"}));
}

TEST(IntegratorTest, RefusesAnInitialValueThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Integrator<> block(IntegratorParams<>{.initial = nan}); }, "initial"));
}

}  // namespace
}  // namespace tenon::integrator_test
