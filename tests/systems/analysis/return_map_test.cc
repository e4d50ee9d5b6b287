#include <tenon/systems/analysis/return_map.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::return_map_test {

using ::testing::ElementsAre;

/// x'' = (1 - x²) x' - x, and the integral of its divergence 1 - x².
struct VanDerPol final : LeafSystem<void> {
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}, Vec<2>(2, 0)};
  ContinuousState<double> growth{this, "growth"};
  OutputPort<Vec<2>> state{this, x};
  TimeDerivative<Vec<2>> dx{x, Uses(x),
                            [](const Vec<2>& x) { return Vec<2>(x[1], (1 - x[0] * x[0]) * x[1] - x[0]); }};
  TimeDerivative<double> dgrowth{growth, Uses(x), [](const Vec<2>& x) { return 1 - x[0] * x[0]; }};
};
constexpr double kVanDerPolPeriod = 6.663286859323;  // s

TEST(ReturnMapTest, VanDerPol) {
  // One multiplier is 1, along the flow; the other is exp of the integral of the divergence (Liouville).
  DiagramBuilder builder;
  auto& oscillator = builder.Add<VanDerPol>("oscillator");
  const auto context = builder.Build()->CreateContext();
  const ReturnMapResult result =
      ReturnMap(*context, {.map = {.period = kVanDerPolPeriod, .states = {&oscillator.x}},
                           .settle_periods = 4,
                           .time_is_neutral = true});
  Simulator simulator(context->Clone(), {.order = 5, .rtol = 1e-11, .atol = 1e-13});
  simulator.RunTo(4 * kVanDerPolPeriod);
  const double before = simulator.context().Eval(oscillator.growth);
  simulator.RunTo(5 * kVanDerPolPeriod);
  const double multiplier = std::exp(simulator.context().Eval(oscillator.growth) - before);

  EXPECT_DOUBLE_EQ(result.map.time, 4 * kVanDerPolPeriod);
  EXPECT_LT(result.residual.norm(), 1e-8);
  ASSERT_EQ(result.multipliers.size(), 1);
  EXPECT_NEAR(std::abs(result.multipliers[0] - multiplier), 0, 1e-7);
  EXPECT_NEAR(multiplier, 8.597e-4, 1e-7);
  ASSERT_EQ(result.neutral_multipliers.size(), 1);
  EXPECT_NEAR(std::abs(result.neutral_multipliers[0] - 1.0), 0, 1e-6);
  EXPECT_LT(result.neutral_defect, 1e-6);
  EXPECT_THAT(result.map.states, ElementsAre("oscillator.x.position", "oscillator.x.velocity"));
}

TEST(ReturnMapTest, WithoutNeutralDirectionsAllMultipliersAreSortedByModulus) {
  DiagramBuilder builder;
  builder.Add<VanDerPol>("oscillator");
  const auto diagram = builder.Build();
  const ReturnMapResult result =
      ReturnMap(*diagram->CreateContext(),
                {.map = {.period = kVanDerPolPeriod, .scales = {{"m", 1}, {"m/s", 1}}}, .settle_periods = 4});
  ASSERT_EQ(result.multipliers.size(), 3);  // of the integral too, on which nothing depends
  EXPECT_NEAR(std::abs(result.multipliers[0]), 1, 1e-6);
  EXPECT_NEAR(std::abs(result.multipliers[1]), 1, 1e-6);
  EXPECT_NEAR(std::abs(result.multipliers[2]), 8.597e-4, 1e-6);
  EXPECT_EQ(result.neutral_multipliers.size(), 0);
  EXPECT_EQ(result.neutral_defect, 0);
}

/// A ball on a floor that restores the energy of each bounce: v+ = -e v- + kick.
struct BallParams {
  double restitution = 0.8;
  double kick = 1;  // m/s
  double g = 9.81;  // m/s²
};
struct Ball final : LeafSystem<BallParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "height, velocity"}};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [this](const Vec<2>& x) { return Vec<2>(x[1], -params.g); }};
  Witness touch{this, "touch", Crossing::kFalling, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Update<Vec<2>> bounce{x, touch, Uses(x), [this](const Vec<2>& x) {
                          return Vec<2>(0, -params.restitution * x[1] + params.kick);
                        }};
};

TEST(ReturnMapTest, BouncingBall) {
  // It leaves the floor with v = kick / (1 - e) each time; a deviation of that velocity shrinks by e.
  DiagramBuilder builder;
  auto& ball = builder.Add<Ball>("ball");
  const auto context = builder.Build()->CreateContext();
  const double v = 1 / (1 - 0.8), g = 9.81;
  context->Set(ball.x, Vec<2>(v * v / 2 / g, 0));
  const ReturnMapResult result =
      ReturnMap(*context, {.map = {.period = 2 * v / g, .steps = {1e-4, 2e-4}}, .time_is_neutral = true});
  EXPECT_LT(result.residual.norm(), 1e-8);
  ASSERT_EQ(result.multipliers.size(), 1);
  EXPECT_NEAR(std::abs(result.multipliers[0] - 0.8), 0, 1e-5);
  EXPECT_NEAR(std::abs(result.neutral_multipliers[0] - 1.0), 0, 1e-5);
  EXPECT_LT(result.neutral_defect, 1e-5);
  EXPECT_LT(result.map.spread.maxCoeff(), 1e-4);
}

/// A cart under a PD controller at 100 Hz that tracks a ramp of 0.5 m/s.
struct RampLoop : PdLoop {
  RampLoop() : PdLoop({.kp = 30, .kd = 8, .rate = Hz(100)}) {
    auto& ramp = builder.AddFunction({"ramp", "m"}, Uses(builder.time), [](double t) { return 0.5 * t; });
    builder.Connect(ramp, pd.ref);
    diagram = builder.Build();
  }
  std::shared_ptr<const Diagram> diagram;
};

/// (Φ - Γ K)^ticks of a sampled PD on a cart of 2 kg.
Eigen::Matrix2d SampledPd(double kp, double kd, int ticks) {
  const double h = 0.01;
  Eigen::Matrix2d A = (Eigen::Matrix2d() << 1, h, 0, 1).finished();
  A -= Eigen::Vector2d(h * h / 4, h / 2) * Eigen::RowVector2d(kp, kd);
  Eigen::Matrix2d power = Eigen::Matrix2d::Identity();
  for (int i = 0; i < ticks; ++i) power = A * power;
  return power;
}

TEST(ReturnMapTest, MovingReference) {
  RampLoop loop;
  const ReturnMapResult result =
      ReturnMap(*loop.diagram->CreateContext(),
                {.map = {.period = 0.2}, .settle_periods = 50, .advance = {{"cart.x.position", 0.5 * 0.2}}});
  EXPECT_LT(result.residual.norm(), 1e-9);
  EXPECT_NEAR(result.map.x0[1], 0.5, 1e-9);
  const Eigen::Matrix2d A = SampledPd(30, 8, 20);
  EXPECT_THAT(result.map.A, IsNear(A, 1e-7));
  const Eigen::VectorXcd multipliers = test::Eigenvalues(A);  // a pair
  EXPECT_NEAR(std::abs(result.multipliers[0]), std::abs(multipliers[0]), 1e-7);
  EXPECT_NEAR(std::abs(result.multipliers[0].imag()), std::abs(multipliers[0].imag()), 1e-7);
  EXPECT_DOUBLE_EQ(result.map.time, 10);
}

TEST(ReturnMapTest, ReferenceThatMovesByAFunction) {
  RampLoop loop;
  const auto context = loop.diagram->CreateContext();
  const auto mirror = [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return -x; };
  const ReturnMapResult result = ReturnMap(*context, {.map = {.period = 0.2}, .bring_back = mirror});
  EXPECT_THAT(result.map.A, IsNear(-SampledPd(30, 8, 20), 1e-7));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        ReturnMap(*context,
                  {.bring_back = [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return x.head(1); }});
      },
      "bring_back"));
}

TEST(ReturnMapTest, PlaceIsNeutral) {
  // The velocity of the cart is controlled, its position is not: a shifted cart stays shifted.
  PdLoop loop({.kp = 0, .kd = 8, .rate = Hz(100)});
  const auto context = loop.builder.Build()->CreateContext();
  const ReturnMapResult result =
      ReturnMap(*context, {.map = {.period = 0.1}, .neutral = {{{"cart.x.position", 1}}}});
  ASSERT_EQ(result.multipliers.size(), 1);
  EXPECT_NEAR(std::abs(result.multipliers[0] - std::pow(1 - 8 * 0.01 / 2, 10)), 0, 1e-8);
  EXPECT_NEAR(std::abs(result.neutral_multipliers[0] - 1.0), 0, 1e-8);
  EXPECT_LT(result.neutral_defect, 1e-8);
  // The velocity is not neutral: it is damped and changes the position.
  EXPECT_GT(ReturnMap(*context, {.neutral = {{{"cart.x.velocity", 1}}}}).neutral_defect, 1e-3);
}

TEST(ReturnMapTest, WrongDirectionsAreRefused) {
  RampLoop loop;
  const auto context = loop.diagram->CreateContext();
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        ReturnMap(*context, {.advance = {{"cart.x.positon", 1}}});
      },
      "'cart.x.positon'", "'cart.x.position'"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        ReturnMap(*context, {.neutral = {{{"cart.x.position", 1}}, {{"cart.x.position", 2}}}});
      },
      "neutral"));
  EXPECT_TRUE(Throws<ParameterError>([&] { ReturnMap(*context, {.neutral = {{}}}); }, "neutral"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { ReturnMap(*context, {.map = {.period = 0.005}}); }, "period = 0.005 s"));
}

}  // namespace tenon::return_map_test
