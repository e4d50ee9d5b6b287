// Logs and monitors change nothing: at ticks that reach no derivative, states are read from the integrator's
// dense output.

#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::dense_output_test {

struct Case {
  Method method;
  int order;
};

void PrintTo(const Case& c, std::ostream* os) {
  *os << NameOf(c.method) << c.order;
}

double Solution(double t) {
  return std::cos(t);
}

/// Keeps the largest deviation from the solution at the ends of steps.
struct EndsOfSteps final : LeafSystem<void> {
  InputPort<double> x{this, "x"};
  Monitor look{this, "look", EachStep{}, Uses(x, time), &EndsOfSteps::Look};
  mutable double worst = 0;

 private:
  Verdict Look(double x, double t) const {
    worst = std::max(worst, std::abs(x - Solution(t)));
    return {};
  }
};

struct DenseOutputTest : testing::TestWithParam<Case> {
  /// Runs `diagram` with a log and without.
  void Compare(DiagramBuilder& builder, const OutputPort<double>& x, double rtol, double allowed,
               double duration) {
    auto& ends = builder.Add<EndsOfSteps>("ends");
    builder.Connect(x, ends.x);
    const auto diagram = builder.Build();
    const SimulatorOptions options{.method = GetParam().method,
                                   .order = GetParam().order,
                                   .rtol = rtol,
                                   .atol = rtol,
                                   .max_steps = 1000000};
    Simulator alone(*diagram, options), logged(*diagram, options);
    const auto log = logged.AddLog(Hz(1000), {&x});
    alone.RunTo(duration);
    logged.RunTo(duration);

    EXPECT_EQ(logged.context().Eval(x), alone.context().Eval(x));
    const IntegratorStatistics with = logged.statistics(), without = alone.statistics();
    EXPECT_EQ(with.evaluations, without.evaluations);
    EXPECT_EQ(with.steps, without.steps);
    EXPECT_LE(with.interpolant_evaluations, 5 * with.steps);
    ASSERT_EQ(log->rows(), static_cast<std::size_t>(std::lround(1000 * duration)) + 1);
    double worst = 0;
    for (std::size_t i = 0; i < log->rows(); ++i)
      worst = std::max(worst, std::abs(log->row(i)[1] - Solution(log->row(i)[0])));
    EXPECT_LE(worst, ends.worst + allowed * rtol);
  }
};

TEST_P(DenseOutputTest, ALogOfAnOscillatorChangesNothing) {
  DiagramBuilder builder;
  auto& plant = builder.Add<Oscillator>("plant");
  auto& q = builder.AddFunction("q", Uses(plant.state), [](const Vec<2>& x) { return x[0]; });
  Compare(builder, q, 1e-8, 10, 100);
}

using StiffDenseOutputTest = DenseOutputTest;

/// The interpolant of the first steps, which has few points, is the least exact: its error is 117 tolerances
/// for order 2, whose steps are a quarter of a second.
TEST_P(StiffDenseOutputTest, ALogOfAStiffStateChangesNothing) {
  DiagramBuilder builder;
  auto& stiff = builder.Add<Stiff>("stiff");
  Compare(builder, stiff.state, 1e-6, 150, 10);
}

/// A run restored inside a step continues as the run that was not interrupted, bit for bit.
TEST_P(DenseOutputTest, GoesOnFromInsideAStepBitForBit) {
  DiagramBuilder builder;
  auto& plant = builder.Add<Oscillator>("plant");
  const auto diagram = builder.Build();
  const SimulatorOptions options{.method = GetParam().method, .order = GetParam().order, .rtol = 1e-8};
  Simulator straight(*diagram, options), first(*diagram, options), second(*diagram, options);
  const auto straight_log = straight.AddLog(Hz(1000), {&plant.x}), log = second.AddLog(Hz(1000), {&plant.x});
  straight.RunTo(5);
  first.RunTo(2.345);
  second.context().Restore(first.context().Save());
  EXPECT_EQ(second.context().Eval(plant.x), first.context().Eval(plant.x));
  second.RunTo(5);
  EXPECT_EQ(second.context().Eval(plant.x), straight.context().Eval(plant.x));
  ASSERT_EQ(log->rows(), 2655);
  for (std::size_t i = 0; i < log->rows(); ++i) {
    const auto row = log->row(i), expected = straight_log->row(i + 2346);
    EXPECT_TRUE(std::ranges::equal(row, expected)) << row[0];
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, DenseOutputTest,
                         testing::Values(Case{Method::kErk, 3}, Case{Method::kErk, 4}, Case{Method::kErk, 5},
                                         Case{Method::kStabilized, 3}, Case{Method::kDirk, 3},
                                         Case{Method::kDirk, 4}, Case{Method::kDirk, 5},
                                         Case{Method::kBdf, 5}, Case{Method::kAdams, 12}),
                         testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(Methods, StiffDenseOutputTest,
                         testing::Values(Case{Method::kDirk, 2}, Case{Method::kDirk, 3},
                                         Case{Method::kDirk, 4}, Case{Method::kDirk, 5},
                                         Case{Method::kBdf, 5}),
                         testing::PrintToStringParamName());

TEST(DenseOutput, ACloneRunWithOtherOptionsBeginsWhereItIs) {
  DiagramBuilder builder;
  auto& plant = builder.Add<Oscillator>("plant");
  Simulator coarse(builder.Build(), {.order = 5, .rtol = 1e-2, .atol = 1e-2});
  coarse.RunTo(1.234);
  const Vec<2> there = coarse.context().Eval(plant.x);
  Simulator fine(coarse.context().Clone(), {.order = 3, .fixed_step = 1e-3});
  fine.RunTo(1.234);
  EXPECT_EQ(fine.context().Eval(plant.x), there);
  fine.RunTo(2);
  EXPECT_NEAR(fine.statistics().last_step, 1e-3, 1e-12);
  const double t = 2 - 1.234;
  EXPECT_NEAR(fine.context().Eval(plant.x)[0], there[0] * std::cos(t) + there[1] * std::sin(t), 1e-7);
}

TEST(DenseOutput, StatesOfOthersAreLeftAloneWhereNothingIsIntegrated) {
  struct Block final : LeafSystem<void> {
    DiscreteState<double> kept{this, "kept", 7.0};
    Witness zero{this, "zero", Crossing::kBoth, Uses(time), [](double t) { return t - 5; }};
  };
  for (const Method method : kAllMethods) {
    DiagramBuilder builder;
    auto& block = builder.Add<Block>("block");
    Simulator simulator(*builder.Build(), {.method = method});
    simulator.RunTo(1.23);
    EXPECT_EQ(simulator.context().Eval(block.kept), 7);
  }
}

struct CountingWitness final : LeafSystem<int*> {
  explicit CountingWitness(int* calls) : LeafSystem(calls) {}
  InputPort<Vec<2>> x{this, "x"};
  Witness zero{this, "zero", Crossing::kBoth, Uses(x), [this](const Vec<2>& x) { return ++*params, x[0]; }};
};

TEST(DenseOutput, ReadingTicksAskNoWitness) {
  const auto calls = [](bool reading) {
    int count = 0;
    DiagramBuilder builder;
    auto& plant = builder.Add<Oscillator>("plant");
    builder.Connect(plant.state, builder.Add<CountingWitness>("witness", &count).x);
    builder.Add<Counter>("counter", Sampled{reading ? Hz(1000) : Seconds(1000)});
    Simulator simulator(*builder.Build());
    simulator.RunTo(10);
    return count;
  };
  EXPECT_EQ(calls(true), calls(false));
}

// Runs that begin at large times, such as seconds since 1970, where a double resolves time only coarsely.
constexpr double kNow = 1.76e9;  // a double resolves 2.4e-7 s here

/// q = cos 500 t, with a sampled force of zero, whose ticks restart the integrator.
struct Vibration {
  explicit Vibration(Rate rate) : body(builder.Add<Oscillator>("body", 500.0)) {
    AddRestarts(builder, "force", rate, body.u);
    diagram = builder.Build();
  }
  std::unique_ptr<Context> ContextAt(double time) const {
    auto context = diagram->CreateContext();
    context->SetTime(time);
    return context;
  }
  DiagramBuilder builder;
  Oscillator& body;
  std::shared_ptr<const Diagram> diagram;
};

TEST(LargeTimesTest, ARunIsThatFromZero) {
  const Vibration vibration(Hz(500));
  for (const Method method : kAllMethods) {
    const SimulatorOptions options{.method = method, .rtol = 1e-6, .atol = 1e-6};
    Simulator first(vibration.ContextAt(0), options);
    const auto wanted = first.AddLog(Hz(130), {&vibration.body.state});
    first.RunTo(1);
    EXPECT_NEAR(first.context().Eval(vibration.body.x)[0], std::cos(500), 1e-2);  // 80 periods
    for (const double start : {1e4, 1e7, 1e8, kNow}) {
      Simulator simulator(vibration.ContextAt(start), options);
      const auto log = simulator.AddLog(Hz(130), {&vibration.body.state});  // inside the steps
      simulator.RunTo(start + 1);
      ASSERT_EQ(log->rows(), 131U);
      for (std::size_t i = 0; i < log->rows(); ++i)
        ASSERT_NEAR(log->row(i)[1], wanted->row(i)[1], 20e-6) << NameOf(method) << ' ' << start << ' ' << i;
    }
  }
}

TEST(LargeTimesTest, DividedAndSavedRunsContinueBitForBit) {
  const Vibration vibration(Hz(500));
  Simulator whole(vibration.ContextAt(kNow));
  whole.RunTo(kNow + 0.1);
  const Eigen::VectorXd wanted = whole.context().continuous_state();
  Simulator divided(vibration.ContextAt(kNow));
  for (int i = 1; i <= 30; ++i) {
    divided.RunTo(kNow + 0.1 * i / 30);
    Simulator saved(vibration.ContextAt(0));
    saved.context().Restore(divided.context().Save());
    saved.RunTo(kNow + 0.1);
    EXPECT_EQ(saved.context().continuous_state(), wanted) << i;
  }
  EXPECT_EQ(divided.context().continuous_state(), wanted);
}

TEST(LargeTimesTest, NoTickAfterTheEndRuns) {
  DiagramBuilder builder;
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10e6)});
  const auto diagram = builder.Build();
  for (const double start : {0.0, 1.0, 1000.0, 1e5}) {
    auto context = diagram->CreateContext();
    context->SetTime(start);
    Simulator simulator(std::move(context));
    const auto count = [&] { return simulator.context().Eval(counter.n); };
    simulator.RunTo(start);
    EXPECT_EQ(count(), 1) << start;
    simulator.RunTo(start + 2.5e-7);  // between two ticks
    EXPECT_EQ(count(), 3) << start;
    static_cast<void>(simulator.AdvanceToBefore(start + 10e-7));
    EXPECT_EQ(count(), 10) << start;
    simulator.RunTo(start + 10e-7);
    EXPECT_EQ(count(), 11) << start;
  }
}

TEST(LargeTimesTest, TicksThatADoubleCannotDistinguishAreRefused) {
  DiagramBuilder builder;
  builder.Add<Counter>("counter", Sampled{Hz(10e6)});
  auto context = builder.Build()->CreateContext();
  context->SetTime(kNow);
  EXPECT_TRUE(Throws<RunError>([&] { Simulator simulator(std::move(context)); }, "'counter.next n'",
                               "begin the run at an earlier time"));
}

}  // namespace tenon::dense_output_test
