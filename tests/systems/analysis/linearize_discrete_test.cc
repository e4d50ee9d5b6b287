#include <tenon/systems/analysis/return_map.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::linearize_discrete_test {

using ::testing::ElementsAre, ::testing::IsEmpty;

constexpr double kMass = 2;

/// The double integrator under a constant force for `h` seconds, exactly.
Eigen::Matrix2d Phi(double h) {
  return (Eigen::Matrix2d() << 1, h, 0, 1).finished();
}
Eigen::Vector2d Gamma(double h) {
  return {h * h / 2 / kMass, h / kMass};
}

/// A cart under a PD controller at 100 Hz.
struct CartLoop : PdLoop {
  CartLoop() : PdLoop({.kp = 30, .kd = 8, .rate = Hz(100)}, {.mass = kMass}) {}
  std::shared_ptr<const Diagram> diagram = builder.BuildWithOpenInputs();
};

using LinearizeDiscreteTest = DiagramTest;

TEST_F(LinearizeDiscreteTest, SampledPdOnADoubleIntegrator) {
  CartLoop loop;
  const auto context = loop.diagram->CreateContext();
  context->Set(loop.cart.x, Vec<2>(0.3, -0.1));
  context->Set(loop.pd.ref, 0.2);
  const DiscreteLinearModel model =
      LinearizeDiscrete(*context, {&loop.pd.ref}, {&loop.cart.state, &loop.pd.u});

  const Eigen::RowVector2d K(30, 8);
  const Eigen::Vector2d x0(0.3, -0.1);
  EXPECT_THAT(model.A, IsNear(Phi(0.01) - Gamma(0.01) * K, 1e-8));
  EXPECT_THAT(model.B, IsNear(Gamma(0.01) * 30, 1e-8));
  Eigen::MatrixXd C(3, 2), D(3, 1);
  C << 1, 0, 0, 1, -30, -8;
  D << 0, 0, 30;
  EXPECT_THAT(model.C, IsNear(C, 1e-8));
  EXPECT_THAT(model.D, IsNear(D, 1e-8));
  EXPECT_EQ(model.x0, x0);
  EXPECT_EQ(model.u0[0], 0.2);
  EXPECT_NEAR(model.y0[2], 30 * (0.2 - 0.3) + 0.8, 1e-12);
  EXPECT_THAT(model.x1, IsNear(Phi(0.01) * x0 + Gamma(0.01) * model.y0[2], 1e-10));
  EXPECT_EQ(model.time, 0);
  EXPECT_DOUBLE_EQ(model.period, 0.01);
  EXPECT_THAT(model.states, ElementsAre("cart.x.position", "cart.x.velocity"));
  EXPECT_THAT(model.inputs, ElementsAre("pd.ref"));
  EXPECT_THAT(model.outputs, ElementsAre("cart.x.position", "cart.x.velocity", "pd.u"));
  EXPECT_THAT(model.flips, IsEmpty());
}

TEST_F(LinearizeDiscreteTest, BeginsAtTheNextTickAndLeavesTheContextAsItIs) {
  CartLoop loop;
  Simulator simulator(*loop.diagram);
  simulator.context().Set(loop.pd.ref, 0.2);
  for (const auto& [now, begin] : {std::pair(0.0, 0.01), {0.034, 0.04}, {0.05, 0.06}}) {
    simulator.RunTo(now);
    const auto before = simulator.context().Save();
    const DiscreteLinearModel model = LinearizeDiscrete(simulator.context(), {}, {});
    EXPECT_DOUBLE_EQ(model.time, begin);
    EXPECT_THAT(model.A, IsNear(Phi(0.01) - Gamma(0.01) * Eigen::RowVector2d(30, 8), 1e-8));
    EXPECT_EQ(simulator.context().Save(), before);
  }
  ASSERT_FALSE(simulator.AdvanceToBefore(0.08).ended);
  EXPECT_DOUBLE_EQ(LinearizeDiscrete(simulator.context(), {}, {}).time, 0.08);
}

TEST_F(LinearizeDiscreteTest, APlantAloneIsHeldForThePeriodGiven) {
  // q'' = -w² q + u: a turn by w h.
  auto& plant = builder.Add<Oscillator>("plant", 3.0);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->SetTime(0.123);
  const DiscreteLinearModel model =
      LinearizeDiscrete(*context, {&plant.u}, {&plant.state, &plant.u}, {.period = 0.2});
  const double c = std::cos(0.6), s = std::sin(0.6);
  EXPECT_THAT(model.A, IsNear((Eigen::Matrix2d() << c, s / 3, -3 * s, c).finished(), 1e-8));
  EXPECT_THAT(model.B, IsNear(Eigen::Vector2d((1 - c) / 9, s / 3), 1e-8));
  EXPECT_THAT(model.C, IsNear((Eigen::MatrixXd(3, 2) << 1, 0, 0, 1, 0, 0).finished(), 1e-9));
  EXPECT_THAT(model.D, IsNear(Eigen::Vector3d(0, 0, 1), 1e-9));
  EXPECT_EQ(model.time, 0.123);
}

TEST_F(LinearizeDiscreteTest, ChainOfUnitDelays) {
  auto& first = builder.Add<UnitDelay<>>("first", {.initial = 1, .rate = Hz(50)});
  auto& second = builder.Add<UnitDelay<>>("second", {.initial = 2, .rate = Hz(50)});
  builder.Connect(first.y, second.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(first.u, 3.0);
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {&first.u}, {&second.y});
  EXPECT_THAT(model.states, ElementsAre("first.x", "second.x"));
  EXPECT_THAT(model.A, IsNear((Eigen::Matrix2d() << 0, 0, 1, 0).finished(), 1e-9));
  EXPECT_THAT(model.B, IsNear(Eigen::Vector2d(1, 0), 1e-9));
  EXPECT_THAT(model.C, IsNear(Eigen::RowVector2d(0, 1), 1e-9));
  EXPECT_THAT(model.D, IsNear(Eigen::Matrix<double, 1, 1>(0.0), 1e-9));
  EXPECT_EQ(model.x0, Eigen::Vector2d(1, 2));
  EXPECT_EQ(model.x1, Eigen::Vector2d(3, 1));
  EXPECT_EQ(model.y0[0], 2);
  EXPECT_THAT(LinearizeDiscrete(*context, {}, {}, {.left_out = {&first.x}}).states, ElementsAre("second.x"));
}

TEST_F(LinearizeDiscreteTest, TwoRates) {
  // A spring at 2 ms and a damper at 3 ms: ticks at 0, 2, 3, 4 of 6 ms.
  auto& cart = builder.Add<Cart>("cart", {.mass = kMass});
  auto& spring = builder.Add<Pd>("spring", {.kp = 900, .kd = 0, .rate = Milliseconds(2)});
  auto& damper = builder.Add<Pd>("damper", {.kp = 0, .kd = 70, .rate = Milliseconds(3)});
  builder.Connect(cart.state, spring.x);
  builder.Connect(cart.state, damper.x);
  builder.Connect(
      builder.AddFunction("sum", Uses(spring.u, damper.u), [](double a, double b) { return a + b; }),
      cart.force);
  const auto diagram = builder.Build();
  const DiscreteLinearModel model = LinearizeDiscrete(*diagram->CreateContext(), {}, {});

  // The state is (x, v, force of the spring, force of the damper).
  const auto flow = [](double h) {
    Eigen::Matrix4d F = Eigen::Matrix4d::Identity();
    F.topLeftCorner<2, 2>() = Phi(h);
    F.topRightCorner<2, 2>() << Gamma(h), Gamma(h);
    return F;
  };
  Eigen::Matrix4d spring_tick = Eigen::Matrix4d::Identity(), damper_tick = Eigen::Matrix4d::Identity();
  spring_tick.row(2) << -900, 0, 0, 0;
  damper_tick.row(3) << 0, -70, 0, 0;
  const Eigen::Matrix4d period = flow(0.002) * spring_tick * flow(0.001) * damper_tick * flow(0.001) *
                                 spring_tick * flow(0.002) * damper_tick * spring_tick;
  EXPECT_DOUBLE_EQ(model.period, 0.006);
  EXPECT_THAT(model.A, IsNear(period.topLeftCorner<2, 2>(), 1e-8));

  const DiscreteLinearModel twice = LinearizeDiscrete(*diagram->CreateContext(), {}, {}, {.period = 0.012});
  EXPECT_THAT(twice.A, IsNear(model.A * model.A, 1e-8));
}

/// y = gain u, sampled with an offset.
struct LateGainParams {
  double gain = -1;
  Sampled sampled{Hz(100), 0.004};
};
struct LateGain final : LeafSystem<LateGainParams> {
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> u{this, "u"};
  OutputPort<Vec<2>> y{this, "y", Vec<2>(Vec<2>::Zero()), params.sampled, Uses(u), &LateGain::Calc};

 private:
  Vec<2> Calc(const Vec<2>& u) const { return params.gain * u; }
};

TEST_F(LinearizeDiscreteTest, WhatIsHeldOverTheBeginCarriesOn) {
  // The force is computed 4 ms after the beginning of each period: until then the old one acts.
  auto& cart = builder.Add<Cart>("cart", {.mass = kMass});
  auto& late = builder.Add<LateGain>("late", {.gain = -40});
  builder.Connect(cart.state, late.u, IgnoreUnits{});
  builder.Connect(builder.AddFunction("force", Uses(late.y), [](const Vec<2>& y) { return y[0]; }),
                  cart.force, IgnoreUnits{});
  const auto context = builder.Build()->CreateContext();
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {}, {&late.y});
  EXPECT_THAT(model.states, ElementsAre("cart.x.position", "cart.x.velocity", "late.y.0", "late.y.1"));
  EXPECT_DOUBLE_EQ(model.time, 0.01);  // the first multiple of the period after the first tick

  Eigen::Matrix4d before = Eigen::Matrix4d::Identity(), tick = before, after = before;
  before.topLeftCorner<2, 2>() = Phi(0.004);
  before.block<2, 1>(0, 2) = Gamma(0.004);
  tick.bottomRows<2>() << -40 * Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Zero();
  after.topLeftCorner<2, 2>() = Phi(0.006);
  after.block<2, 1>(0, 2) = Gamma(0.006);
  EXPECT_THAT(model.A, IsNear(after * tick * before, 1e-8));
  EXPECT_THAT(model.C.rightCols<2>(), IsNear(Eigen::Matrix2d::Identity(), 1e-9));  // no tick at the begin
}

TEST_F(LinearizeDiscreteTest, HeldSamplesThatAreRenewedBeforeTheyAreReadCarryNothing) {
  // `early` is computed at 4 ms and read at 8 ms, so its old value is never read.
  auto& cart = builder.Add<Cart>("cart");
  auto& early = builder.Add<LateGain>("early");
  auto& late = builder.Add<LateGain>("late", {.gain = 2, .sampled = {Hz(100), 0.008}});
  builder.Connect(cart.state, early.u, IgnoreUnits{});
  builder.Connect(early.y, late.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(cart.force, 0.0);
  EXPECT_THAT(LinearizeDiscrete(*context, {}, {}).states, ElementsAre("cart.x.position", "cart.x.velocity"));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}, {.states = {&early.y}}); },
                               "'early.y'", "t = 0.01 s"));
}

/// An integral in Scratch: value += u h; and the number of ticks.
struct Sum {
  double value = 0;
  int ticks = 0;
  static FieldList Fields() { return {{"value", &Sum::value, "m s"}, {"ticks", &Sum::ticks}}; }
};
struct ScratchIntegrator final : LeafSystem<void> {
  InputPort<double> u{this, {"u", "m"}};
  Scratch<Sum> sum{this, "sum"};
  OutputPort<double> y{this, {"y", "m s"}, Sampled{Hz(10)}, Uses(u, sum), [](double u, Sum& sum) {
                         sum.value += 0.1 * u;
                         ++sum.ticks;
                         return sum.value;
                       }};
};

TEST_F(LinearizeDiscreteTest, ScratchIsState) {
  auto& integrator = builder.Add<ScratchIntegrator>("integrator");
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(integrator.u, 5.0);
  context->Set(integrator.sum, Sum{7, 3});
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {&integrator.u}, {&integrator.y});
  EXPECT_THAT(model.states, ElementsAre("integrator.sum.value"));
  EXPECT_EQ(model.x0[0], 7);
  EXPECT_NEAR(model.A(0, 0), 1, 1e-9);
  EXPECT_NEAR(model.B(0, 0), 0.1, 1e-9);
  EXPECT_NEAR(model.C(0, 0), 1, 1e-9);
  EXPECT_NEAR(model.D(0, 0), 0.1, 1e-9);
  EXPECT_THAT(model.flips, IsEmpty());  // it counts in all runs alike
}

enum class Side { kBelow, kAbove };

/// Its mode says on which side of 0.3 the position is.
struct Latch final : LeafSystem<void> {
  InputPort<Vec<2>> x{this, "x"};
  Mode<Side> side{this, "side"};
  Update<Side> next{side, Sampled{Hz(100)}, Uses(x),
                    [](const Vec<2>& x) { return x[0] > 0.3 ? Side::kAbove : Side::kBelow; }};
};

TEST_F(LinearizeDiscreteTest, FlipsAreNamed) {
  auto& cart = builder.Add<Cart>("cart");
  auto& latch = builder.Add<Latch>("latch");
  builder.Connect(cart.state, latch.x, IgnoreUnits{});
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(cart.force, 0.0);
  context->Set(cart.x, Vec<2>(0.3, 0));
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {}, {});
  ASSERT_EQ(model.flips.size(), 1);
  EXPECT_EQ(model.flips[0].signal, "latch.side");
  EXPECT_EQ(model.flips[0].moved, "cart.x.position");
  EXPECT_THAT(model.states, ElementsAre("cart.x.position", "cart.x.velocity"));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}, {.refuse_flips = true}); },
                               "'latch.side'", "'cart.x.position'"));
  context->Set(cart.x, Vec<2>(0.31, 0));
  EXPECT_NO_THROW(LinearizeDiscrete(*context, {}, {}, {.refuse_flips = true}));
}

TEST_F(LinearizeDiscreteTest, NoiseIsTheSameInAllRuns) {
  auto& noise = builder.Add<AddNoise<>>("noise", {.standard_deviation = 5});
  auto& delay = builder.Add<UnitDelay<>>("delay");
  builder.Connect(noise.y, delay.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext(7);
  context->Set(noise.u, 0.0);
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {&noise.u}, {});
  EXPECT_NE(model.x1[0], 0);
  EXPECT_NEAR(model.B(0, 0), 1, 1e-9);
}

/// x[n+1] = x[n]³, with a member that is not finite.
struct CubeState {
  double x = 2, last = -std::numeric_limits<double>::infinity();
  static FieldList Fields() { return {{"x", &CubeState::x, "m"}, {"last", &CubeState::last, "s"}}; }
};
struct Cube final : LeafSystem<void> {
  DiscreteState<CubeState> state{this, "state", CubeState()};
  Update<CubeState> next{state, Sampled{Hz(1)}, Uses(state), [](const CubeState& s) {
                           return CubeState{s.x * s.x * s.x, s.last};
                         }};
};

TEST_F(LinearizeDiscreteTest, StepsAreAveragedAndTheirSpreadIsTold) {
  // ((x + h)³ - (x - h)³) / 2 h = 3 x² + h²
  auto& cube = builder.Add<Cube>("cube");
  const auto diagram = builder.Build();
  const DiscreteLinearModel model =
      LinearizeDiscrete(*diagram->CreateContext(), {}, {}, {.steps = {0.1, 0.3}, .scales = {{"m", 2}}});
  EXPECT_NEAR(model.A(0, 0), 12 + (0.2 * 0.2 + 0.6 * 0.6) / 2, 1e-12);
  EXPECT_NEAR(model.spread[0], (0.6 * 0.6 - 0.2 * 0.2) / 2, 1e-12);
  // Elements that are not finite are not perturbed.
  EXPECT_EQ(model.A.col(1), Eigen::Vector2d::Zero());
  EXPECT_EQ(model.A(1, 0), 0);
  const DiscreteLinearModel plain =
      LinearizeDiscrete(*diagram->CreateContext(), {}, {}, {.states = {&cube.state}, .steps = {0.1}});
  EXPECT_NEAR(plain.A(0, 0), 12 + 0.3 * 0.3, 1e-12);  // 1 + |x| is 3
}

TEST_F(LinearizeDiscreteTest, StatesCanBeChosen) {
  CartLoop loop;
  const auto context = loop.diagram->CreateContext();
  context->Set(loop.pd.ref, 0.0);
  const DiscreteLinearModel model = LinearizeDiscrete(*context, {}, {}, {.states = {&loop.cart.state}});
  EXPECT_THAT(model.states, ElementsAre("cart.x.position", "cart.x.velocity"));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}, {.states = {&loop.pd.u}}); },
                               "'pd.u'", "t = 0 s"));
}

TEST_F(LinearizeDiscreteTest, OptionsThatMakeNoSense) {
  CartLoop loop;
  const auto context = loop.diagram->CreateContext();
  const auto refuses = [&](const LinearizeDiscreteOptions& options, const char* text) {
    return Throws<ParameterError>([&] { LinearizeDiscrete(*context, {}, {}, options); }, text);
  };
  EXPECT_TRUE(refuses({.period = 0.015}, "period = 0.015 s"));
  EXPECT_TRUE(refuses({.period = -0.01}, "period = -0.01 s"));
  EXPECT_TRUE(refuses({.steps = {}}, "steps"));
  EXPECT_TRUE(refuses({.steps = {1e-5, 0}}, "step 0"));
  EXPECT_TRUE(refuses({.scales = {{"m", -1}}}, "'m'"));
  builder.Add<Oscillator>("plant");
  const auto unsampled = builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<ParameterError>([&] { LinearizeDiscrete(*unsampled, {}, {}); }, "options.period"));
}

TEST_F(LinearizeDiscreteTest, InputsMustBeOpenAndSet) {
  CartLoop loop;
  const auto context = loop.diagram->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {&loop.pd.u}, {}); }, "'pd.u'"));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {&loop.pd.x}, {}); }, "'pd.x'", "'cart.x'"));
  auto& cart = builder.Add<Cart>("cart");
  const auto diagram = builder.BuildWithOpenInputs();
  EXPECT_TRUE(Throws<RunError>(
      [&] { LinearizeDiscrete(*diagram->CreateContext(), {&cart.force}, {}, {.period = 1}); },
      "'cart.force'"));
}

/// Ends the run at a tick where the position is beyond the limit.
struct Fence final : LeafSystem<double> {
  explicit Fence(double limit) : LeafSystem(limit) {}
  InputPort<Vec<2>> x{this, "x"};
  Monitor beyond{this, "beyond", Sampled{Hz(100)}, Uses(x), [this](const Vec<2>& x) -> Verdict {
                   if (x[0] > params) return "too far";
                   return {};
                 }};
};

TEST_F(LinearizeDiscreteTest, RunsThatEndAreNamed) {
  auto& cart = builder.Add<Cart>("cart");
  auto& fence = builder.Add<Fence>("fence", 1.0);
  builder.Connect(cart.state, fence.x, IgnoreUnits{});
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(cart.force, 0.0);
  context->Set(cart.x, Vec<2>(1, 0));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}); }, "'cart.x.position'", "t = 0 s",
                               "fence.beyond"));
  context->Set(cart.x, Vec<2>(2, 0));
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}); }, "t = 0 s"));
}

/// A state whose size grows at each tick, and an output whose size depends on the input.
struct Growing final : LeafSystem<void> {
  InputPort<double> size{this, "size"};
  DiscreteState<std::vector<double>> list{this, "list", {1.0}};
  OutputPort<std::vector<double>> copy{this, "copy", Uses(size),
                                       [](double size) { return std::vector<double>(size > 1 ? 2 : 1); }};
  Update<std::vector<double>> next{list, Sampled{Hz(1)}, Uses(list), [](const std::vector<double>& list) {
                                     std::vector<double> longer = list;
                                     longer.push_back(0);
                                     return longer;
                                   }};
};

TEST_F(LinearizeDiscreteTest, WhatChangesItsSizeHasNoDerivative) {
  auto& growing = builder.Add<Growing>("growing");
  auto& delay = builder.Add<UnitDelay<>>("delay", {.rate = Hz(1)});
  builder.Connect(delay.y, growing.size);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(delay.u, 0.0);
  context->Set(delay.x, 1.0);
  EXPECT_TRUE(Throws<RunError>([&] { LinearizeDiscrete(*context, {}, {}); }, "'growing.list'", "t = 1 s"));
  EXPECT_TRUE(Throws<RunError>(
      [&] { LinearizeDiscrete(*context, {}, {&growing.copy}, {.states = {&delay.x}}); }, "outputs"));
  EXPECT_NO_THROW(LinearizeDiscrete(*context, {}, {}, {.states = {&delay.x}}));
}

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

}  // namespace tenon::linearize_discrete_test
