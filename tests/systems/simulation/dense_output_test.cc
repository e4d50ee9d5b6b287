// Who only looks changes nothing: states at ticks that reach no derivative are read from inside the
// integrator's steps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon {
namespace {

struct Case {
  Method method;
  int order;
};

void PrintTo(const Case& c, std::ostream* os) {
  constexpr const char* kNames[] = {"Erk", "Dirk", "Bdf", "Adams"};
  *os << kNames[static_cast<int>(c.method)] << c.order;
}

double Solution(double t) {
  return std::cos(t);
}

/// Keeps the largest deviation from the solution at the ends of steps.
class EndsOfSteps final : public LeafSystem<void> {
 public:
  InputPort<double> x{this, "x"};
  Monitor look{this, "look", EachStep{}, Uses(x, time), &EndsOfSteps::Look};
  mutable double worst = 0;

 private:
  Verdict Look(double x, double t) const {
    worst = std::max(worst, std::abs(x - Solution(t)));
    return {};
  }
};

/// Prothero and Robinson: x' = -1e5 (x - cos t) - sin t from 1: x = cos t.
class Stiff final : public LeafSystem<void> {
 public:
  ContinuousState<double> x{this, "x", 1.0};
  OutputPort<double> y{this, x};
  TimeDerivative<double> dx{x, Uses(x, time),
                            [](double x, double t) { return -1e5 * (x - std::cos(t)) - std::sin(t); }};
};

class DenseOutputTest : public testing::TestWithParam<Case> {
 protected:
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
    for (std::size_t i = 0; i < log->rows(); ++i) {
      worst = std::max(worst, std::abs(log->row(i)[1] - Solution(log->row(i)[0])));
    }
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

/// The first steps, of few states to go through, are the least exact: 117 tolerances for order 2, whose steps
/// are a quarter of a second.
TEST_P(StiffDenseOutputTest, ALogOfAStiffStateChangesNothing) {
  DiagramBuilder builder;
  auto& stiff = builder.Add<Stiff>("stiff");
  Compare(builder, stiff.y, 1e-6, 150, 10);
}

/// A clone or a restored snapshot goes on inside a step as the run that was not interrupted.
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
                                         Case{Method::kDirk, 3}, Case{Method::kDirk, 4},
                                         Case{Method::kDirk, 5}, Case{Method::kBdf, 5},
                                         Case{Method::kAdams, 12}),
                         testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(Methods, StiffDenseOutputTest,
                         testing::Values(Case{Method::kDirk, 2}, Case{Method::kDirk, 3},
                                         Case{Method::kDirk, 4}, Case{Method::kDirk, 5},
                                         Case{Method::kBdf, 5}),
                         testing::PrintToStringParamName());

class CountingWitness final : public LeafSystem<int*> {
 public:
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

}  // namespace
}  // namespace tenon
