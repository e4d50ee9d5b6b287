#include <tenon/systems/analysis/analysis.h>
#include <tenon/systems/analysis/sensitivity.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::analysis_test {

using ::testing::ElementsAre;

/// θ'' = -(g/l) sin θ - d θ' + τ.
struct PendulumParams {
  double gravity_over_length = 9.81;  // 1/s²
  double damping = 0.3;               // 1/s
};
struct Pendulum final : LeafSystem<PendulumParams> {
  using LeafSystem::LeafSystem;
  InputPort<double> torque{this, {"torque", "1/s^2"}};
  ContinuousState<Vec<2>> x{this, {"x", "rad, rad/s", "angle, rate"}};
  OutputPort<Vec<2>> state{this, x};
  OutputPort<Vec<2>> tip{this, {"tip", "", "x, y"}, Uses(x), &Pendulum::CalcTip};
  TimeDerivative<Vec<2>> dx{x, Uses(x, torque), &Pendulum::CalcDx};

 private:
  Vec<2> CalcTip(const Vec<2>& x) const { return {std::sin(x[0]), -std::cos(x[0])}; }
  Vec<2> CalcDx(const Vec<2>& x, double torque) const {
    return {x[1], -params.gravity_over_length * std::sin(x[0]) - params.damping * x[1] + torque};
  }
};

/// A nested diagram of the pendulum and its controller.
struct Robot final : Subdiagram {
  Robot() : pendulum(Add<Pendulum>("pendulum")), pd(Add<Pd>("pd", PdParams{.kp = 5, .kd = 1})) {
    Connect(pendulum.state, pd.x, IgnoreUnits{});  // made for a cart
    Connect(ref, pd.ref);
    Connect(AddFunction("sum", Uses(pd.u, push), [](double u, double push) { return u + push; }),
            pendulum.torque);
    Connect(pendulum.tip, tip);
  }
  InputPort<double> ref{this, "ref", 0.0};
  InputPort<double> push{this, "push"};
  OutputPort<Vec<2>> tip{this, {"tip", "", "x, y"}};
  Pendulum& pendulum;
  Pd& pd;
};

Eigen::Matrix2d PendulumA(double angle) {
  Eigen::Matrix2d A;
  A << 0, 1, -9.81 * std::cos(angle), -0.3;
  return A;
}

using AnalysisTest = DiagramTest;

TEST_F(AnalysisTest, LinearizesAboutAnyState) {
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(pendulum.x, Vec<2>(0.7, 0.2));
  context->Set(pendulum.torque, 1.5);
  const auto before = context->Save();
  const LinearModel model = Linearize(*context, {&pendulum.torque}, {&pendulum.tip, &pendulum.torque});
  EXPECT_EQ(context->Save(), before);
  EXPECT_TRUE(model.A.isApprox(PendulumA(0.7), 1e-8)) << model.A;
  EXPECT_TRUE(model.B.isApprox(Eigen::Vector2d(0, 1), 1e-8)) << model.B;
  Eigen::MatrixXd C(3, 2), D(3, 1);
  C << std::cos(0.7), 0, std::sin(0.7), 0, 0, 0;
  D << 0, 0, 1;
  EXPECT_TRUE(model.C.isApprox(C, 1e-8)) << model.C;
  EXPECT_TRUE(model.D.isApprox(D, 1e-8)) << model.D;
  EXPECT_EQ(model.x0, Eigen::Vector2d(0.7, 0.2));
  EXPECT_EQ(model.u0[0], 1.5);
  EXPECT_NEAR(model.xdot0[1], -9.81 * std::sin(0.7) - 0.06 + 1.5, 1e-12);
  EXPECT_NEAR(model.y0[1], -std::cos(0.7), 1e-15);
  EXPECT_THAT(model.states, ElementsAre("pendulum.x.angle", "pendulum.x.rate"));
  EXPECT_THAT(model.inputs, ElementsAre("pendulum.torque"));
  EXPECT_THAT(model.outputs, ElementsAre("pendulum.tip.x", "pendulum.tip.y", "pendulum.torque"));
}

/// A force, and the index of the cart (of 1 kg) on which it acts.
struct Pull {
  int cart = 0;
  double force = 0;  // [N]
  static FieldList Fields() { return {{"cart", &Pull::cart}, {"force", &Pull::force, "N"}}; }
};
struct Carts final : LeafSystem<void> {
  InputPort<Pull> pull{this, {"pull"}};
  ContinuousState<Vec<2>> v{this, {"v", "m/s"}};
  TimeDerivative<Vec<2>> dv{v, Uses(pull), &Carts::CalcDv};

 private:
  Vec<2> CalcDv(const Pull& pull) const { return pull.force * Vec<2>::Unit(pull.cart); }
};

TEST_F(AnalysisTest, WhatIsNoRealNumberStays) {
  auto& carts = builder.Add<Carts>("carts");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(carts.pull, Pull{1, 3});
  const LinearModel model = Linearize(*context, {&carts.pull}, {});
  EXPECT_THAT(model.inputs, ElementsAre("carts.pull.force"));
  EXPECT_TRUE(model.B.isApprox(Eigen::Vector2d(0, 1), 1e-8)) << model.B;
  FindEquilibrium(*context, {.free_inputs = {&carts.pull}});
  EXPECT_EQ(context->Eval(carts.pull).cart, 1);
  EXPECT_NEAR(context->Eval(carts.pull).force, 0, 1e-9);
}

TEST_F(AnalysisTest, SamplesAreHeld) {
  // The controller's feedback is held between ticks, so it is not in A; its command can serve as input.
  auto& robot = builder.Add<Robot>("robot");
  Simulator simulator(builder.BuildWithOpenInputs());
  simulator.context().Set(robot.push, 0.0);
  simulator.context().Set(robot.pendulum.x, Vec<2>(0.1, 0));
  simulator.Initialize();
  const LinearModel model = Linearize(simulator.context(), {&robot.pd.u, &robot.push}, {&robot.tip});
  EXPECT_TRUE(model.A.isApprox(PendulumA(0.1), 1e-8)) << model.A;
  EXPECT_TRUE(model.B.row(1).isApprox(Eigen::RowVector2d(1, 1), 1e-8)) << model.B;
  EXPECT_NEAR(model.u0[0], -5 * 0.1, 1e-12);
  EXPECT_THAT(model.states, ElementsAre("robot.pendulum.x.angle", "robot.pendulum.x.rate"));
  EXPECT_THAT(model.inputs, ElementsAre("robot.pd.u", "robot.push"));
  EXPECT_THAT(model.outputs, ElementsAre("robot.tip.x", "robot.tip.y"));
}

TEST_F(AnalysisTest, ComputedPortsAreNoInputs) {
  auto& robot = builder.Add<Robot>("robot");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(robot.push, 0.0);
  context->Set(robot.pd.u, 0.0);
  EXPECT_TRUE(Throws<RunError>([&] { Linearize(*context, {&robot.pendulum.torque}, {}); },
                               "'robot.pendulum.torque'", "'robot.sum.output'"));
}

TEST_F(AnalysisTest, InputsWithoutValueAreRefused) {
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { Linearize(*context, {}, {}); }, "'pendulum.torque'"));
  EXPECT_TRUE(Throws<RunError>([&] { FindEquilibrium(*context, {.free_inputs = {&pendulum.torque}}); },
                               "'pendulum.torque'"));
}

TEST_F(AnalysisTest, DiagramsWithoutStatesAreLinearizedToo) {
  auto& map = builder.Add<Map>("map", [](double u) { return u * u; });
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(map.u, 3.0);
  const LinearModel model = Linearize(*context, {&map.u}, {&map.y});
  EXPECT_EQ(model.A.size(), 0);
  EXPECT_NEAR(model.D(0, 0), 6, 1e-8);
  EXPECT_NO_THROW(FindEquilibrium(*context));
}

TEST_F(AnalysisTest, PendulumRestsWhereTorqueAndGravityBalance) {
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(pendulum.torque, 5.0);
  context->Set(pendulum.x, Vec<2>(0.1, 0.4));
  FindEquilibrium(*context);
  EXPECT_NEAR(context->Eval(pendulum.x)[0], std::asin(5 / 9.81), 1e-9);
  EXPECT_NEAR(context->Eval(pendulum.x)[1], 0, 1e-9);
  EXPECT_EQ(context->Eval(pendulum.torque), 5);
  context->Set(pendulum.x, Vec<2>(2.9, 0));  // the upper one is nearer
  FindEquilibrium(*context);
  EXPECT_NEAR(context->Eval(pendulum.x)[0], M_PI - std::asin(5 / 9.81), 1e-9);
}

TEST_F(AnalysisTest, FamilyOfEquilibriaGivesANearOne) {
  auto& cart = builder.Add<Cart>("cart");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(cart.force, 0.0);
  context->Set(cart.x, Vec<2>(3, 1));
  FindEquilibrium(*context);
  EXPECT_NEAR(context->Eval(cart.x)[0], 3, 1e-6);
  EXPECT_NEAR(context->Eval(cart.x)[1], 0, 1e-10);
  context->Set(cart.force, 4.0);
  EXPECT_TRUE(Throws<RunError>([&] { FindEquilibrium(*context); }, "'cart.x.velocity'"));
}

TEST_F(AnalysisTest, TrimSolvesForInputsToo) {
  // No torque balances the rate, but the torque may change: any angle near the first will do.
  auto& robot = builder.Add<Robot>("robot");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(robot.push, 20.0);  // more than gravity can hold
  context->Set(robot.pd.u, 0.0);
  context->Set(robot.pendulum.x, Vec<2>(0.5, 0.1));
  EXPECT_THROW(FindEquilibrium(*context->Clone()), RunError);
  FindEquilibrium(*context, {.free_inputs = {&robot.pd.u}});
  const Vec<2> x = context->Eval(robot.pendulum.x);
  EXPECT_NEAR(x[1], 0, 1e-9);
  EXPECT_NEAR(9.81 * std::sin(x[0]), 20 + context->Eval(robot.pd.u), 1e-8);
  EXPECT_EQ(context->Eval(robot.push), 20);
  EXPECT_NEAR(context->EvalTimeDerivatives().norm(), 0, 1e-10);
}

/// v' = f(v) + u, y = f(u).
struct Bent final : LeafSystem<std::function<double(double)>> {
  explicit Bent(std::function<double(double)> f) : LeafSystem(std::move(f)) {}
  InputPort<double> u{this, "u"};
  ContinuousState<double> v{this, {"v", "m/s"}};
  OutputPort<double> y{this, "y", Uses(u), [this](double u) { return params(u); }};
  TimeDerivative<double> dv{v, Uses(v, u), [this](double v, double u) { return params(v) + u; }};
};

/// A Bent linearised at v and u.
struct AtPoint {
  explicit AtPoint(std::function<double(double)> f, double v, double u)
      : bent(builder.Add<Bent>("bent", std::move(f))),
        context(builder.BuildWithOpenInputs()->CreateContext()) {
    context->Set(bent.v, v);
    context->Set(bent.u, u);
  }
  LinearModel Model() const { return Linearize(*context, {&bent.u}, {&bent.y}); }
  DiagramBuilder builder;
  Bent& bent;
  std::unique_ptr<Context> context;
};

TEST_F(AnalysisTest, LinearizeRefusesKinksAndJumps) {
  const auto limit = [](double x) { return std::clamp(3 * x, -6.0, 6.0); };
  const auto sign = [](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; };
  const auto abs = [](double x) { return std::abs(x); };
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint(limit, 2, 0).Model(); }, "'bent.v'"));
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint(limit, 0, -2).Model(); }, "'bent.y'", "'bent.u'"));
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint(abs, 0, 1).Model(); }, "'bent.v'"));
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint(sign, 0, 1).Model(); }, "'bent.v'"));
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint([](double x) { return x < 0 ? 0.0 : 1.0; }, 0, 1).Model(); },
                               "'bent.v'"));
  // The kink lies within the step of the central difference.
  EXPECT_TRUE(Throws<RunError>([&] { AtPoint(abs, 5e-7, 1).Model(); }, "'bent.v'"));
}

TEST_F(AnalysisTest, LinearizesBesideAKink) {
  const auto limit = [](double x) { return std::clamp(3 * x, -6.0, 6.0); };
  EXPECT_EQ(AtPoint(limit, 2.001, 3).Model().A(0, 0), 0);
  EXPECT_NEAR(AtPoint(limit, 1.999, 3).Model().A(0, 0), 3, 1e-8);
  EXPECT_NEAR(AtPoint([](double x) { return std::abs(x); }, 1e-5, 1).Model().A(0, 0), 1, 1e-8);
}

// Neither strong curvature nor rounding errors of large values count as a kink.
TEST_F(AnalysisTest, LinearizesWhateverIsSmooth) {
  EXPECT_NEAR(AtPoint([](double x) { return 1e6 * x * x; }, 0, 0).Model().A(0, 0), 0, 1e-8);
  EXPECT_NEAR(AtPoint([](double x) { return 1e6 * x * x * x; }, 1, 0).Model().A(0, 0), 3e6, 1);
  EXPECT_NEAR(AtPoint([](double x) { return x > 0 ? 1e3 * x * x : 0; }, 0, 0).Model().A(0, 0), 0, 1e-3);
  EXPECT_NEAR(AtPoint([](double x) { return std::sin(100 * x); }, 0.3, 0).Model().A(0, 0), 100 * std::cos(30),
              1e-5);
  EXPECT_NEAR(AtPoint([](double x) { return 1e9 + std::sin(x); }, 0, 0).Model().A(0, 0), 1, 1e-1);
  EXPECT_NEAR(AtPoint([](double x) { return (x + 1e7) - 1e7; }, 0, 0).Model().A(0, 0), 1, 1e-2);
  EXPECT_NEAR(AtPoint([](double x) { return std::tanh(1e4 * x); }, 0, 0).Model().A(0, 0), 1e4, 1);
}

struct FreeCart {
  DiagramBuilder builder;
  Cart& cart = builder.Add<Cart>("cart", {.mass = 2});
  std::shared_ptr<const Diagram> diagram = builder.BuildWithOpenInputs();
  std::unique_ptr<Context> context = diagram->CreateContext();
};

TEST(SensitivityTest, OfARunInClosedForm) {
  // J = (p + v T + F T²/2 m)²
  FreeCart free;
  free.context->Set(free.cart.x, Vec<2>(0.5, 0.2));
  free.context->Set(free.cart.force, 3.0);
  const auto before = free.context->Save();
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start));
    const auto log = simulator.AddLog(Hz(1), {&free.cart.state});
    simulator.RunTo(2);
    return std::pow(log->column("cart.x.position").back(), 2);
  };
  const SensitivityResult result = Sensitivity(*free.context, {&free.cart.force, &free.cart.x}, figure);
  const double end = 0.5 + 0.2 * 2 + 3;
  EXPECT_NEAR(result.figure, end * end, 1e-9);
  ASSERT_EQ(result.gradient.size(), 3);
  EXPECT_NEAR(result.gradient[0], 2 * end, 1e-6);
  EXPECT_NEAR(result.gradient[1], 2 * end, 1e-6);
  EXPECT_NEAR(result.gradient[2], 2 * end * 2, 1e-6);
  EXPECT_THAT(result.names, ElementsAre("cart.force", "cart.x.position", "cart.x.velocity"));
  EXPECT_THAT(result.units, ElementsAre("N", "m", "m/s"));
  EXPECT_EQ(free.context->Save(), before);
}

TEST(SensitivityTest, StepsAreRelativeToTheValueOrToTheScaleOfItsUnit) {
  // For h above F, (|F + h| - |F - h|) / 2 h = F / h shows the step h.
  FreeCart free;
  free.context->Set(free.cart.force, 0.1);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    return std::abs(start->Eval(free.cart.force));
  };
  const auto slope = [&](const SensitivityOptions& options) {
    return Sensitivity(*free.context, {&free.cart.force}, figure, options).gradient[0];
  };
  EXPECT_NEAR(slope({}), 1, 1e-9);
  EXPECT_NEAR(slope({.step = 2}), 0.1 / 0.2, 1e-9);
  EXPECT_NEAR(slope({.step = 0.5, .scales = {{"N", 8}}}), 0.1 / 4, 1e-9);
  free.context->Set(free.cart.force, 0.0);
  EXPECT_NEAR(slope({}), 0, 1e-12);
}

TEST(SensitivityTest, NoiseIsTheSameInAllRuns) {
  DiagramBuilder builder;
  auto& noise = builder.Add<AddNoise<>>("noise", {.standard_deviation = 5});
  auto& delay = builder.Add<UnitDelay<>>("delay");
  builder.Connect(delay.y, noise.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext(4);
  context->Set(delay.u, 0.0);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start));
    simulator.Initialize();
    return simulator.context().Eval(noise.y);
  };
  const SensitivityResult result = Sensitivity(*context, {&delay.x}, figure);
  EXPECT_NE(result.figure, 0);
  EXPECT_NEAR(result.gradient[0], 1, 1e-9);
}

TEST(SensitivityTest, OfALoggedFigureToAGain) {
  // y = 1 - exp(-t/τ) at the second log of 1 Hz: dy/dτ = -t/τ² exp(-t/τ).
  DiagramBuilder builder;
  auto& filter = builder.Add<LowPassFilter<>>("filter", {.time_constant = 0.8});
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(filter.u, 1.0);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start), {.rtol = 1e-10, .atol = 1e-12});
    const auto log = simulator.AddLog(Hz(1), {&filter.y});
    simulator.RunTo(1.5);
    return log->column("filter.y").back();
  };
  const SensitivityResult result = Sensitivity(*context, {&filter.time_constant}, figure);
  EXPECT_NEAR(result.figure, 1 - std::exp(-1 / 0.8), 1e-9);
  EXPECT_NEAR(result.gradient[0], -1 / (0.8 * 0.8) * std::exp(-1 / 0.8), 1e-6);
  EXPECT_THAT(result.names, ElementsAre("filter.time_constant"));
}

TEST(SensitivityTest, WhatCannotBeMovedIsRefused) {
  PdLoop loop;
  auto& counter = loop.builder.Add<Counter>("counter", Sampled{Hz(1)});
  const auto context = loop.builder.Build()->CreateContext();
  const Figure nothing = [](std::unique_ptr<Context>) { return 0.0; };
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*context, {&counter.n}, nothing); }, "'counter.n'"));
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*context, {&loop.pd.x}, nothing); }, "'pd.x'", "'cart.x'"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Sensitivity(*context, {&loop.cart.x}, nothing, {.step = 0}); }, "step"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Sensitivity(*context, {&loop.cart.x}, nothing, {.scales = {{"m", 0}}});
      },
      "'m'"));
}

TEST(SensitivityTest, RunsThatFailAreNamed) {
  FreeCart free;
  free.context->Set(free.cart.force, 1.0);
  const Figure root = [&](std::unique_ptr<Context> start) {
    return std::sqrt(1 - start->Eval(free.cart.force));
  };
  EXPECT_TRUE(
      Throws<RunError>([&] { Sensitivity(*free.context, {&free.cart.force}, root); }, "'cart.force'", "nan"));
  const Figure failing = [](std::unique_ptr<Context>) -> double { throw RunError("it fell"); };
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*free.context, {&free.cart.force}, failing); }, "it fell"));
}

}  // namespace tenon::analysis_test
