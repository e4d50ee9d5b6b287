#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/transfer_function.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/LU>

#include <cmath>
#include <complex>
#include <numbers>

namespace tenon::transfer_function_test {

using Params = TransferFunctionParams;

TEST(TransferFunctionTest, FirstOrderStepResponse) {
  TestRig<TransferFunction<1>> rig({.numerator = {6}, .denominator = {2, 4}});  // 1.5 / (1 + 0.5 s)
  rig.Fix(rig->u, 2);
  for (const double t : {0.0, 0.3, 1.0}) {
    EXPECT_NEAR(rig.RunTo(t)[rig->y], 3 * (1 - std::exp(-2 * t)), 1e-9);
  }
}

TEST(TransferFunctionTest, OscillatorWithAZeroAndFeedthrough) {
  // (s^2 + s + 3) / (s^2 + 2 s + 5) = 1 - (s + 2) / ((s + 1)^2 + 4), whose last term has the impulse
  // response e^-t (cos 2t + 1/2 sin 2t).
  TestRig<TransferFunction<2>> rig({.numerator = {1, 1, 3}, .denominator = {1, 2, 5}});
  rig.Fix(rig->u, 1);
  for (const double t : {0.0, 0.4, 2.0}) {
    const double c = std::exp(-t) * std::cos(2 * t), s = std::exp(-t) * std::sin(2 * t);
    const double integral = (1 - c + 2 * s) / 5 + 0.5 * (2 - 2 * c - s) / 5;
    EXPECT_NEAR(rig.RunTo(t)[rig->y], 1 - integral, 1e-9) << t;
  }
}

/// y / u of the block at s, from its state equations.
template <int Order>
std::complex<double> Response(TestRig<TransferFunction<Order>>& rig, std::complex<double> s) {
  using Matrix = Eigen::Matrix<std::complex<double>, Order, Order>;
  Matrix a;
  Eigen::Vector<std::complex<double>, Order> b;
  Eigen::RowVector<std::complex<double>, Order> c;
  rig.Fix(rig->u, 0);
  for (int i = 0; i < Order; ++i) {
    rig.Set(rig->x, Vec<Order>::Unit(i));
    a.col(i) = rig.Derivative(rig->x).template cast<std::complex<double>>();
    c[i] = rig[rig->y];
  }
  rig.Set(rig->x, Vec<Order>::Zero()).Fix(rig->u, 1);
  b = rig.Derivative(rig->x).template cast<std::complex<double>>();
  const Matrix resolvent = (s * Matrix::Identity() - a).inverse();
  return (c * resolvent * b).value() + rig[rig->y];
}

TEST(TransferFunctionTest, HasTheFrequencyResponse) {
  const std::complex<double> s(0.2, 3);
  TestRig<TransferFunction<3>> rig({.numerator = {4, 3, -2, 7}, .denominator = {-2, 5, 1, 11}});
  const auto expected =
      (4. * s * s * s + 3. * s * s - 2. * s + 7.) / (-2. * s * s * s + 5. * s * s + s + 11.);
  EXPECT_NEAR(std::abs(Response(rig, s) - expected), 0, 1e-12);

  TestRig<TransferFunction<4>> integrators({.numerator = {3}, .denominator = {2, 0, 0, 0, 0}});
  EXPECT_NEAR(std::abs(Response(integrators, s) - 1.5 / std::pow(s, 4)), 0, 1e-12);

  TestRig<TransferFunction<8>> eighth(
      Params{.numerator = {1, 2}, .denominator = {1, 8, 28, 56, 70, 56, 28, 8, 1}});
  EXPECT_NEAR(std::abs(Response(eighth, s) - (s + 2.) / std::pow(s + 1., 8)), 0, 1e-12);
}

TEST(TransferFunctionTest, FastFiltersKeepTheirAccuracy) {
  // Butterworth, order 4, 1000 rad/s: w^4 = 1e12 must not make an absolute tolerance of 1e-9 useless.
  const double w = 1000, k = 2.613125929752753, m = 2 + std::numbers::sqrt2;
  DiagramBuilder builder;
  auto& filter = builder.Add<TransferFunction<4>>(
      "filter",
      {.numerator = {w * w * w * w}, .denominator = {1, k * w, m * w * w, k * w * w * w, w * w * w * w}});
  auto& input = builder.AddFunction("input", Uses(builder.time), [w](double t) { return std::sin(w * t); });
  builder.Connect(input, filter.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.05);
  // At its corner frequency the filter has the gain 1 / sqrt(2) and turns the phase by -180 degrees.
  EXPECT_NEAR(simulator.context().Eval(filter.y), -std::sin(w * 0.05) / std::numbers::sqrt2, 1e-4);
}

TEST(TransferFunctionTest, HasFeedthroughOnlyIfNotStrictlyProper) {
  const auto build = [](std::vector<double> numerator) {
    DiagramBuilder builder;
    auto& plant =
        builder.Add<TransferFunction<2>>("plant", {.numerator = numerator, .denominator = {1, 2, 1}});
    auto& gain = builder.Add<Gain<>>("gain", {.gain = -1});
    builder.Connect(plant.y, gain.u);
    builder.Connect(gain.y, plant.u);
    builder.Build();
  };
  EXPECT_NO_THROW(build({1, 0}));
  EXPECT_NO_THROW(build({0, 1, 0}));
  EXPECT_TRUE(Throws<BuildError>([&] { build({1, 0, 0}); }, "plant.y", "gain.y"));
}

TEST(TransferFunctionTest, RefusesBadCoefficients) {
  EXPECT_TRUE(Refuses<TransferFunction<2>>({}, "denominator"));
  EXPECT_TRUE(Refuses<TransferFunction<2>>({.denominator = {1, 2}}, "denominator"));
  EXPECT_TRUE(Refuses<TransferFunction<2>>({.denominator = {0, 1, 2}}, "denominator"));
  EXPECT_TRUE(
      Refuses<TransferFunction<2>>({.numerator = {1, 0, 0, 0}, .denominator = {1, 1, 2}}, "numerator"));
  EXPECT_TRUE(Refuses<TransferFunction<2>>({.numerator = {}, .denominator = {1, 1, 2}}, "numerator"));
  EXPECT_TRUE(Refuses<TransferFunction<2>>({.denominator = {1, test::kNan, 2}}, "coefficients"));
}

}  // namespace tenon::transfer_function_test
