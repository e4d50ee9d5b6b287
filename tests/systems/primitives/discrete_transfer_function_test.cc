#include <tenon/systems/primitives/discrete_transfer_function.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>
#include <vector>

namespace tenon::discrete_transfer_function_test {

using Params = DiscreteTransferFunctionParams;

TEST(DiscreteTransferFunctionTest, FirstOrderStepResponse) {
  TestRig<DiscreteTransferFunction> rig(
      Params{.numerator = {0.4}, .denominator = {2, -1.6}});  // 0.2 / (z - 0.8)
  rig.Fix(rig->u, 3);
  for (int n = 0; n < 30; ++n) EXPECT_NEAR(rig.Tick()[rig->y], 3 * (1 - std::pow(0.8, n)), 1e-14) << n;
}

TEST(DiscreteTransferFunctionTest, ImpulseResponseIsThatOfTheRecursion) {
  const std::vector<double> b = {1, -2, 0.5, 3}, a = {2, 0.4, -0.6, 0.2};
  TestRig<DiscreteTransferFunction> rig({.numerator = b, .denominator = a});
  std::vector<double> y;
  for (std::size_t n = 0; n < 20; ++n) {
    double sum = n < b.size() ? b[n] : 0;
    for (std::size_t i = 1; i < a.size() && i <= n; ++i) sum -= a[i] * y[n - i];
    y.push_back(sum / a[0]);
    EXPECT_NEAR(rig.Fix(rig->u, n == 0 ? 1 : 0).Tick()[rig->y], y[n], 1e-14) << n;
  }
}

TEST(DiscreteTransferFunctionTest, HasFeedthroughOnlyIfNotStrictlyProper) {
  const auto build = [](std::vector<double> numerator) {
    DiagramBuilder builder;
    auto& block =
        builder.Add<DiscreteTransferFunction>("filter", {.numerator = numerator, .denominator = {1, 2, 1}});
    builder.Connect(block.y, block.u);
    builder.Build();
  };
  EXPECT_NO_THROW(build({1, 0}));
  EXPECT_NO_THROW(build({0, 1, 0}));
  EXPECT_TRUE(Throws<BuildError>([&] { build({1, 0, 0}); }, "filter.y"));
}

TEST(DiscreteTransferFunctionTest, RefusesBadCoefficients) {
  EXPECT_TRUE(Refuses<DiscreteTransferFunction>({}, "denominator"));
  EXPECT_TRUE(Refuses<DiscreteTransferFunction>({.denominator = {2}}, "denominator"));
  EXPECT_TRUE(Refuses<DiscreteTransferFunction>({.denominator = {0, 1}}, "denominator"));
  EXPECT_TRUE(
      Refuses<DiscreteTransferFunction>({.numerator = {1, 2, 3}, .denominator = {1, 1}}, "numerator"));
  EXPECT_TRUE(Refuses<DiscreteTransferFunction>({.denominator = {1, test::kNan}}, "coefficients"));
}

}  // namespace tenon::discrete_transfer_function_test
