// Integrators, transfer functions and linear models.

#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/state_space.h>
#include <tenon/systems/primitives/transfer_function.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/LU>

#include <complex>
#include <numbers>

namespace tenon::linear_systems_test {

TEST(IntegratorTest, Integrates) {
  TestRig<Integrator<Vec<2>>> rig({.initial = {1, 2}});
  rig.Fix(rig->u, {3, -4});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Derivative(rig->x), IsNear(Vec<2>(3, -4), 0));
  EXPECT_THAT(rig.RunTo(2)[rig->y], IsNear(Vec<2>(7, -6), 1e-12));
  EXPECT_EQ(rig.diagram().ContinuousStateNames(), (std::vector<std::string>{"block.y.0", "block.y.1"}));
}

TEST(IntegratorTest, RefusesAnInitialValueThatIsNotFinite) {
  EXPECT_TRUE(Refuses<Integrator<>>({.initial = test::kNan}, "initial"));
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

  TestRig<TransferFunction<1>> first({.numerator = {6}, .denominator = {2, 4}});
  EXPECT_NEAR(std::abs(Response(first, s) - 6. / (2. * s + 4.)), 0, 1e-12);

  TestRig<TransferFunction<4>> integrators({.numerator = {3}, .denominator = {2, 0, 0, 0, 0}});
  EXPECT_NEAR(std::abs(Response(integrators, s) - 1.5 / std::pow(s, 4)), 0, 1e-12);

  TestRig<TransferFunction<8>> eighth(
      TransferFunctionParams{.numerator = {1, 2}, .denominator = {1, 8, 28, 56, 70, 56, 28, 8, 1}});
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
  // At its corner frequency the filter has the gain 1 / sqrt(2) and turns the phase by -180 degrees.
  EXPECT_NEAR(ValueAt(0.05, builder, filter.y), -std::sin(w * 0.05) / std::numbers::sqrt2, 1e-4);
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

TEST(DiscreteTransferFunctionTest, FirstOrderStepResponse) {
  TestRig<DiscreteTransferFunction> rig(
      DiscreteTransferFunctionParams{.numerator = {0.4}, .denominator = {2, -1.6}});  // 0.2 / (z - 0.8)
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

/// The oscillator q'' = -4 q + u, its position and velocity.
StateSpaceParams Oscillator() {
  return {.A = Eigen::MatrixXd{{0, 1}, {-4, 0}},
          .B = Eigen::MatrixXd{{0}, {1}},
          .C = Eigen::MatrixXd::Identity(2, 2),
          .initial = Eigen::Vector2d(1, 0),
          .u_unit = "N/kg",
          .x_unit = "m, m/s",
          .y_unit = "m, m/s",
          .x_elements = "q, v"};
}

TEST(StateSpaceTest, IsIntegrated) {
  TestRig<StateSpace> rig(Oscillator());
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[1], "block.x.v");
  rig.Fix(rig->u, Eigen::VectorXd::Constant(1, 2)).RunTo(0.7);
  // An oscillation about the equilibrium at u / 4.
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(0.5 + 0.5 * std::cos(1.4), -std::sin(1.4)), 1e-9));
}

TEST(StateSpaceTest, HasFeedthroughOnlyIfThereIsAD) {
  const auto build = [](StateSpaceParams params) {
    DiagramBuilder builder;
    auto& plant = builder.Add<StateSpace>("plant", std::move(params));
    builder.Connect(plant.y, plant.u);
    return builder.Build();
  };
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  EXPECT_NO_THROW(build({.A = one, .B = one, .C = one}));
  EXPECT_TRUE(Throws<BuildError>([&] { build({.A = one, .B = one, .C = one, .D = one}); }, "algebraic loop"));
  TestRig<StateSpace> rig({.A = one, .B = one, .C = 2 * one, .D = 3 * one, .initial = one});
  EXPECT_EQ(rig.Fix(rig->u, 5 * one)[rig->y][0], 17);
  rig.Set(rig->D, -one);
  EXPECT_EQ(rig[rig->y][0], -3);
}

TEST(StateSpaceTest, RefusesInARunWhatDoesNotFit) {
  TestRig<StateSpace> rig(Oscillator());
  rig.Fix(rig->u, Eigen::Vector2d(1, 2));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Derivative(rig->x); }, "block"));
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->C, Eigen::MatrixXd::Zero(3, 2)); }, "'block.C'"));
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->D, Eigen::MatrixXd::Zero(2, 1)); }, "'block.D'"));
}

TEST(StateSpaceTest, RefusesMatricesThatDoNotFit) {
  const auto refuses = RefusesChanged<StateSpace>(Oscillator());
  EXPECT_TRUE(Refuses<StateSpace>({}, "A must be square"));
  EXPECT_TRUE(refuses([](auto& p) { p.A.resize(2, 3); }, "A must be square"));
  EXPECT_TRUE(refuses([](auto& p) { p.B.resize(3, 1); }, "B must"));
  EXPECT_TRUE(refuses([](auto& p) { p.C.resize(1, 3); }, "C must"));
  EXPECT_TRUE(refuses([](auto& p) { p.D.resize(1, 1); }, "D must"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.resize(3); }, "initial must"));
  EXPECT_TRUE(refuses([](auto& p) { p.B(1, 0) = test::kNan; }, "finite"));
  EXPECT_TRUE(Refuses<DiscreteStateSpace>({}, "A must be square"));
}

TEST(DiscreteStateSpaceTest, StepsByItsMatrices) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  TestRig<DiscreteStateSpace> rig(
      {.model = {.A = 0.5 * one, .B = one, .C = 2 * one, .D = one, .initial = 3 * one}, .rate = Hz(10)});
  rig.Fix(rig->u, one);
  // x = 2 + 0.5^n
  for (int n = 0; n < 10; ++n) EXPECT_EQ(rig.Tick()[rig->y][0], 2 * (2 + std::pow(0.5, n)) + 1);
}

}  // namespace tenon::linear_systems_test
