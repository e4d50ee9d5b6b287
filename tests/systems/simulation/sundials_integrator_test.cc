#include <tenon/tests/systems/framework/test_blocks.h>

#include <fmt/core.h>

#include <tuple>

namespace tenon::sundials_integrator_test {

constexpr Method kMethods[] = {Method::kErk, Method::kDirk, Method::kBdf, Method::kAdams};

/// x' = -x² from 1: x = 1 / (1 + t). And x' = cos(t) x from 1: x = exp(sin t).
struct Scalars final : LeafSystem<void> {
  ContinuousState<Vec<2>> x{this, {"x", "", "decay, wave"}, Vec<2>(1, 1)};
  TimeDerivative<Vec<2>> dx{
      x, Uses(x, time), [](const Vec<2>& x, double t) { return Vec<2>(-x[0] * x[0], std::cos(t) * x[1]); }};
};

double ErrorAt(double end, const SimulatorOptions& options) {
  DiagramBuilder builder;
  auto& scalars = builder.Add<Scalars>("scalars");
  Simulator simulator(builder.Build(), options);
  simulator.RunTo(end);
  const Vec<2> x = simulator.context().Eval(scalars.x);
  return std::max(std::abs(x[0] - 1 / (1 + end)), std::abs(x[1] - std::exp(std::sin(end))));
}

// ---- Accuracy ----

/// Names a case by its method and order and, of a tolerance, by its digits.
constexpr auto kNameOfCase = [](const auto& info) {
  std::string name = fmt::format("{}{}", NameOf(std::get<0>(info.param)), std::get<1>(info.param));
  constexpr std::size_t kSize = std::tuple_size_v<std::remove_cvref_t<decltype(info.param)>>;
  if constexpr (kSize > 2) name += fmt::format("_{:.0f}_digits", -std::log10(std::get<2>(info.param)));
  return name;
};

class FixedStepTest : public testing::TestWithParam<std::tuple<Method, int>> {};

TEST_P(FixedStepTest, ConvergesWithItsOrder) {
  const auto [method, order] = GetParam();
  const auto error = [&, method = method, order = order](double step) {
    return ErrorAt(2, {.method = method, .order = order, .rtol = 1e-10, .atol = 1e-12, .fixed_step = step});
  };
  const double coarse = error(0.1), fine = error(0.05);
  EXPECT_LT(coarse, 1e-2);
  EXPECT_GT(std::log2(coarse / fine), order - 0.3);
  EXPECT_LT(std::log2(coarse / fine), order + 1);
}

INSTANTIATE_TEST_SUITE_P(Stabilized, FixedStepTest,
                         testing::Combine(testing::Values(Method::kStabilized), testing::Range(2, 4)),
                         kNameOfCase);
INSTANTIATE_TEST_SUITE_P(RungeKutta, FixedStepTest,
                         testing::Combine(testing::Values(Method::kErk, Method::kDirk), testing::Range(2, 6)),
                         kNameOfCase);

class AdaptiveTest : public testing::TestWithParam<std::tuple<Method, int, double>> {};

TEST_P(AdaptiveTest, MeetsTheTolerance) {
  const auto [method, order, rtol] = GetParam();
  EXPECT_LT(ErrorAt(5, {.method = method, .order = order, .rtol = rtol, .atol = rtol / 10}), 50 * rtol);
}

INSTANTIATE_TEST_SUITE_P(Stabilized, AdaptiveTest,
                         testing::Combine(testing::Values(Method::kStabilized), testing::Range(2, 4),
                                          testing::Values(1e-3, 1e-5)),
                         kNameOfCase);
INSTANTIATE_TEST_SUITE_P(RungeKutta, AdaptiveTest,
                         testing::Combine(testing::Values(Method::kErk, Method::kDirk), testing::Range(2, 6),
                                          testing::Values(1e-3, 1e-5, 1e-7)),
                         kNameOfCase);
INSTANTIATE_TEST_SUITE_P(Multistep, AdaptiveTest,
                         testing::Combine(testing::Values(Method::kBdf, Method::kAdams),
                                          testing::Values(2, 5), testing::Values(1e-3, 1e-5, 1e-7)),
                         kNameOfCase);

using SundialsIntegratorTest = DiagramTest;

TEST_F(SundialsIntegratorTest, DirkMeetsTheToleranceWhileItsStepsGrow) {
  // With the Jacobian of another step size, Newton's method would stop early with an error of 100 tolerances.
  struct Cooling final : LeafSystem<void> {
    ContinuousState<double> x{this, "x", 10.0};
    TimeDerivative<double> dx{x, Uses(x), [](double x) { return 20 - x; }};
  };
  auto& cooling = builder.Add<Cooling>("cooling");
  const auto diagram = builder.Build();
  for (const int order : {2, 3, 4, 5}) {
    Simulator simulator(*diagram, {.method = Method::kDirk, .order = order, .rtol = 1e-8, .atol = 1e-10});
    simulator.RunTo(0.5);
    EXPECT_NEAR(simulator.context().Eval(cooling.x), 20 - 10 * std::exp(-0.5), 2e-7) << order;
  }
}

TEST_F(SundialsIntegratorTest, ImplicitMethodsStartAtABoundOfTheDomain) {
  // The level of a tank, x' = 1 - x from 0, has no value below 0.
  for (const bool throws : {false, true}) {
    struct Tank final : LeafSystem<void> {
      explicit Tank(bool throws) : throws_(throws) {}
      ContinuousState<double> x{this, "x", 0.0};
      TimeDerivative<double> dx{x, Uses(x), [this](double x) {
                                  if (throws_ && x < 0) throw RunError("the level is negative");
                                  return x < 0 ? std::nan("") : 1 - x;
                                }};

     private:
      bool throws_;
    };
    DiagramBuilder fresh;
    auto& tank = fresh.Add<Tank>("tank", throws);
    const auto diagram = fresh.Build();
    for (const Method method : {Method::kDirk, Method::kBdf, Method::kAdams}) {
      Simulator simulator(*diagram, {.method = method, .rtol = 1e-6, .atol = 1e-8});
      simulator.RunTo(1);
      EXPECT_NEAR(simulator.context().Eval(tank.x), 1 - std::exp(-1), 2e-5) << NameOf(method);
    }
  }
}

TEST_F(SundialsIntegratorTest, ImplicitMethodsTakeLargeStepsWhereItIsStiff) {
  for (const Method method : {Method::kDirk, Method::kBdf}) {
    DiagramBuilder fresh;
    auto& stiff = fresh.Add<Stiff>("stiff");
    Simulator simulator(fresh.Build(), {.method = method, .rtol = 1e-5, .atol = 1e-7});
    simulator.RunTo(3);
    EXPECT_NEAR(simulator.context().Eval(stiff.x), std::cos(3), 1e-4);
    EXPECT_LT(simulator.statistics().steps, 200);  // stability would demand 100000 of an explicit method
    EXPECT_GT(simulator.statistics().largest_step, 0.01);
  }
}

TEST_F(SundialsIntegratorTest, StabilizedMethodsTakeStepsOfFiveTimeConstants) {
  struct Decay final : LeafSystem<void> {
    ContinuousState<double> x{this, "x", 1.0};
    TimeDerivative<double> dx{x, Uses(x), [](double x) { return -x; }};
  };
  auto& decay = builder.Add<Decay>("decay");
  const auto diagram = builder.Build();
  const auto after_ten_steps = [&](Method method, int order) {
    Simulator simulator(*diagram, {.method = method, .order = order, .fixed_step = 5});
    simulator.RunTo(50);
    EXPECT_EQ(simulator.statistics().steps, 10);
    return std::abs(simulator.context().Eval(decay.x));
  };
  for (const int order : {2, 3}) {
    EXPECT_LT(after_ten_steps(Method::kStabilized, order), 0.1) << order;
    EXPECT_GT(after_ten_steps(Method::kErk, order), 1e6) << order;
  }
}

/// A large constant state and a small oscillation: one absolute tolerance for both is too coarse for the
/// latter.
struct TwoScales final : LeafSystem<void> {
  ContinuousState<double> large{this, "large", 1.0};
  ContinuousState<Vec<2>> small{this, "small", Vec<2>(1e-6, 0)};
  TimeDerivative<double> dl{large, Uses(), [] { return 0.0; }};
  TimeDerivative<Vec<2>> ds{small, Uses(small), [](const Vec<2>& x) { return Vec<2>(x[1], -100 * x[0]); }};
};

TEST_F(SundialsIntegratorTest, StatesCanHaveTheirOwnAbsoluteTolerance) {
  const auto error = [](std::vector<StateTolerance> own) {
    DiagramBuilder fresh;
    auto& block = fresh.Add<TwoScales>("block");
    return std::abs(
               ValueAt(5, fresh, block.small, {.rtol = 1e-6, .atol = 1e-6, .state_atol = std::move(own)})[0] -
               1e-6 * std::cos(50)) /
           1e-6;
  };
  EXPECT_GT(error({}), 0.1);  // relative to the state's size
  EXPECT_LT(error({{"block.small", 1e-12}}), 1e-3);
}

// ---- Options ----

TEST_F(SundialsIntegratorTest, OptionsThatMakeNoSenseAreRefused) {
  builder.Add<Oscillator>("plant");
  const auto diagram = builder.Build();
  const auto refused = [&](const SimulatorOptions& options, const std::string& text) {
    EXPECT_TRUE(Throws<ParameterError>([&] { Simulator simulator(*diagram, options); }, text));
  };
  refused({.order = 1}, "2 to 5");
  refused({.order = 6}, "2 to 5");
  refused({.method = Method::kDirk, .order = 1}, "2 to 5");
  refused({.method = Method::kStabilized, .order = 4}, "2 to 3");
  refused({.method = Method::kBdf, .order = 6}, "1 to 5");
  refused({.method = Method::kAdams, .order = 13}, "1 to 12");
  refused({.rtol = 0}, "rtol");
  refused({.rtol = std::nan("")}, "rtol");
  refused({.atol = -1}, "atol");
  refused({.state_atol = {{"plant.x", 0}}}, "'plant.x'");
  refused({.state_atol = {{"plan.x", 1e-9}}}, "'plan.x'");
  refused({.fixed_step = -0.1}, "fixed_step");
  refused({.max_step = -0.1}, "max_step");
  refused({.method = Method::kBdf, .fixed_step = 0.1}, "fixed_step");
}

TEST_F(SundialsIntegratorTest, StepsAreNoLargerThanAsked) {
  for (const Method method : kMethods) {
    DiagramBuilder fresh;
    fresh.Add<Oscillator>("plant", 0.01);
    Simulator simulator(fresh.Build(), {.method = method, .max_step = 0.03});
    simulator.RunTo(1);
    EXPECT_LE(simulator.statistics().largest_step, 0.03 * (1 + 1e-12));
    EXPECT_GE(simulator.statistics().steps, 34);
  }
}

TEST_F(SundialsIntegratorTest, FixedStepsDivideEachIntervalEvenly) {
  AddRestarts(builder, "ticks", Hz(100), builder.Add<Oscillator>("plant").u);
  Simulator simulator(builder.Build(), {.fixed_step = 0.003});  // 4 steps of 2.5 ms an interval
  simulator.RunTo(1);
  const IntegratorStatistics statistics = simulator.statistics();
  EXPECT_EQ(statistics.steps, 400);
  EXPECT_NEAR(statistics.smallest_step, 0.0025, 1e-15);
  EXPECT_NEAR(statistics.largest_step, 0.0025, 1e-15);
}

// ---- Statistics ----

TEST_F(SundialsIntegratorTest, StatisticsCount) {
  for (const Method method : kMethods) {
    DiagramBuilder fresh;
    AddRestarts(fresh, "ticks", Hz(10), fresh.Add<Oscillator>("plant").u);
    Simulator simulator(fresh.Build(), {.method = method});
    EXPECT_EQ(simulator.statistics().steps, 0);
    simulator.RunTo(1);
    const IntegratorStatistics statistics = simulator.statistics();
    EXPECT_GE(statistics.steps, 10);
    EXPECT_LT(statistics.steps, 2000);
    EXPECT_LT(statistics.failed_steps, statistics.steps);
    EXPECT_GT(statistics.evaluations, statistics.steps);
    EXPECT_GT(statistics.smallest_step, 1e-12);  // of CVODE, behind a tick
    EXPECT_LE(statistics.largest_step, 0.1);
    EXPECT_GE(statistics.last_order, 1);
    EXPECT_LE(statistics.last_order, 3);
  }
}

TEST_F(SundialsIntegratorTest, OneStepATickIfTheToleranceAllowsIt) {
  // And, with an open table, no evaluation at its end, where the tick changes the derivatives.
  using Case = std::tuple<Method, int, int>;  // order, evaluations
  for (const auto& [method, order, evaluations] :
       {Case{Method::kErk, 2, 3}, Case{Method::kErk, 3, 4}, Case{Method::kErkOpen, 2, 2},
        Case{Method::kErkOpen, 3, 3}, Case{Method::kStabilized, 2, 3}, Case{Method::kStabilized, 3, 4}}) {
    DiagramBuilder fresh;
    AddRestarts(fresh, "ticks", Hz(1000), fresh.Add<Oscillator>("plant").u);
    Simulator simulator(fresh.Build(), {.method = method, .order = order, .rtol = 1e-4});
    simulator.RunTo(10);
    const IntegratorStatistics statistics = simulator.statistics();
    EXPECT_EQ(statistics.steps, 10000);
    EXPECT_EQ(statistics.failed_steps, 0);
    EXPECT_NEAR(statistics.smallest_step, 1e-3, 1e-12);
    EXPECT_EQ(statistics.evaluations, evaluations * statistics.steps);
  }
}

// ---- Failures ----

/// Blows up at t = 1: x = 1 / (1 - t).
struct Explosion final : LeafSystem<void> {
  ContinuousState<Vec<2>> x{this, {"x", "", "calm, wild"}, Vec<2>(0, 1)};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(1, x[1] * x[1]); }};
};

TEST_F(SundialsIntegratorTest, FailuresNameTheWorstStateAndItsErrorInTolerances) {
  // Step size control keeps the error near one tolerance.
  builder.Add<Explosion>("bomb");
  const auto diagram = builder.Build();
  for (const Method method : {Method::kErk, Method::kBdf}) {
    Simulator simulator(*diagram, {.method = method, .max_steps = 300});
    try {
      simulator.RunTo(2);
      FAIL() << "no exception";
    } catch (const RunError& error) {
      const std::string text = error.what(), before = "(error ";
      const std::size_t at = text.find(before);
      ASSERT_NE(at, std::string::npos) << text;
      EXPECT_NE(text.find("'bomb.x.wild'"), std::string::npos) << text;
      const double tolerances = std::stod(text.substr(at + before.size()));
      EXPECT_GT(tolerances, 1e-4) << text;
      EXPECT_LT(tolerances, 100) << text;
    }
  }
}

TEST_F(SundialsIntegratorTest, SmallerStepsMayAvoidWhatIsNotFinite) {
  // A first guess far too large makes x negative in a stage; smaller steps never do.
  struct Tank final : LeafSystem<void> {
    ContinuousState<double> level{this, "level", 1.0};
    TimeDerivative<double> d{level, Uses(level), [](double h) { return -100 * std::sqrt(h) * h; }};
  };
  auto& tank = builder.Add<Tank>("tank");
  EXPECT_NEAR(ValueAt(1, builder, tank.level, {.rtol = 1e-5}), 1 / (51.0 * 51.0), 1e-5);  // h = (1 + 50 t)^-2
}

}  // namespace tenon::sundials_integrator_test
