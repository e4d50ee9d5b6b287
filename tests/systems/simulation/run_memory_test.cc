// The memory of a run stands in its context: a clone, a restored context and a context that is restored in
// the same simulator continue bit for bit like the undisturbed run, wherever it is interrupted.

#include <tenon/systems/simulation.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <random>

namespace tenon::run_memory_test {

/// A ball that bounces, a relay with a declared kink, a declared and two undeclared jumps in time, and a
/// sampled input. All meet in one vector of states, so that each affects the steps of the others.
struct Everything final : LeafSystem<void> {
  ContinuousState<Vec<5>> x{this, {"x"}, Vec<5>{1, 0, 0.7, 0.1, 0}};
  DiscreteState<int> impacts{this, "impacts"}, passes{this, "passes"};
  OutputPort<double> held{this, "held", Sampled{Seconds(0.37)}, Uses(x),
                          [](const Vec<5>& x) { return std::sin(3 * x[2]); }};
  TimeDerivative<Vec<5>> dx{x, Uses(time, x, held), [](double t, const Vec<5>& x, double held) -> Vec<5> {
                              const double jumps = (t < 0.611 ? 1 : -1) + (t < 2.357 ? 0 : 2);
                              return {x[1], -9.81, x[3], (x[2] > 0.5 ? -1 : 1) - 0.1 * x[3] + 0.2 * held,
                                      jumps + (t < 1.234 ? 0 : 3)};
                            }};
  NextJump next{this, "next", Uses(time), [](double t) { return t < 1.234 ? 1.234 : kNever; }};
  Kink kink{this, "kink", Uses(x), [](const Vec<5>& x) { return x[2] > 0.5 ? 1 : 0; }};
  Witness hit{this, "hit", Crossing::kFalling, Uses(x), [](const Vec<5>& x) { return x[0]; }};
  Update<int> count{impacts, hit, Uses(impacts), [](int n) { return n + 1; }};
  Update<Vec<5>> bounce{x, hit, Uses(x), [](const Vec<5>& x) -> Vec<5> {
                          Vec<5> next = x;
                          next[1] = -0.8 * x[1];
                          return next;
                        }};
  Witness pass{this, "pass", Crossing::kBoth, Uses(x), [](const Vec<5>& x) { return x[3] - 0.05; }};
  Update<int> note{passes, pass, Uses(passes), [](int n) { return n + 1; }};
};

struct Integrator {
  Method method;
  int order;
  double fixed_step = 0;
  double max_step = 0.1;
};
void PrintTo(const Integrator& integrator, std::ostream* os) {
  *os << NameOf(integrator.method) << integrator.order << (integrator.fixed_step > 0 ? "Fixed" : "")
      << (integrator.max_step == 0 ? "Unlimited" : "");
}

struct RunMemoryTest : testing::TestWithParam<Integrator> {
  RunMemoryTest() {
    DiagramBuilder builder;
    block = &builder.Add<Everything>("block");
    diagram = builder.Build();
  }
  SimulatorOptions Options() const {
    const auto& [method, order, fixed_step, max_step] = GetParam();
    return {.method = method, .order = order, .fixed_step = fixed_step, .max_step = max_step};
  }
  std::vector<double> StateOf(const Context& context) const {
    const Eigen::VectorXd x = context.continuous_state();
    std::vector<double> state(x.data(), x.data() + x.size());
    state.push_back(context.Eval(block->impacts));
    state.push_back(context.Eval(block->passes));
    return state;
  }
  std::vector<double> Undisturbed() const {
    Simulator simulator(*diagram, Options());
    simulator.RunTo(kEnd);
    return StateOf(simulator.context());
  }

  static constexpr double kEnd = 3;
  std::shared_ptr<const Diagram> diagram;
  const Everything* block = nullptr;
};

TEST_P(RunMemoryTest, AnInterruptedRunIsTheUndisturbedOne) {
  const std::vector<double> expected = Undisturbed();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, kEnd);
  Simulator run(*diagram, Options());  // one that goes on in the same simulator
  std::vector<double> times{0, 0.44, 0.451, 0.46, 0.611, 1.234, 1.11, 2.22};  // an impact at 0.4515
  while (times.size() < 24) times.push_back(uniform(random));
  std::sort(times.begin(), times.end());
  for (const double time : times) {
    run.RunTo(time);
    const std::vector<std::byte> saved = run.context().Save();

    Simulator cloned(run.context().Clone(), Options());
    cloned.RunTo(kEnd);
    EXPECT_EQ(StateOf(cloned.context()), expected) << "cloned at " << time;

    Simulator restored(*diagram, Options());
    restored.RunTo(0.3);
    restored.context().Restore(saved);
    restored.RunTo(kEnd);
    EXPECT_EQ(StateOf(restored.context()), expected) << "restored at " << time;

    run.RunTo(kEnd);
    EXPECT_EQ(StateOf(run.context()), expected) << "gone on from " << time;
    run.context().Restore(saved);
  }
}

TEST_P(RunMemoryTest, RolloutsOfPredictiveControlLeaveTheRunAlone) {
  Simulator run(*diagram, Options()), rollouts(*diagram, Options());
  for (int i = 1; i <= 300; ++i) {
    run.RunTo(0.01 * i);
    rollouts.context().Restore(run.context().Save());
    if (i % 20 == 0) rollouts.RunTo(std::min(0.01 * i + 0.1, kEnd));
  }
  EXPECT_EQ(StateOf(run.context()), Undisturbed());
}

TEST_P(RunMemoryTest, ARunBeginsAfreshAfterSetTime) {
  Simulator used(*diagram, Options());
  used.RunTo(1.7);
  const std::unique_ptr<Context> initial = diagram->CreateContext();
  used.context().Restore(initial->Save());
  used.context().SetTime(0);
  used.RunTo(kEnd);
  EXPECT_EQ(StateOf(used.context()), Undisturbed());
}

INSTANTIATE_TEST_SUITE_P(AllMethods, RunMemoryTest,
                         testing::Values(Integrator{Method::kErk, 2}, Integrator{Method::kErk, 3},
                                         Integrator{Method::kErk, 4}, Integrator{Method::kErk, 5},
                                         Integrator{Method::kErk, 3, 0, 0}, Integrator{Method::kErk, 3, 0.01},
                                         Integrator{Method::kDirk, 3}, Integrator{Method::kDirk, 4},
                                         Integrator{Method::kDirk, 5}, Integrator{Method::kBdf, 5},
                                         Integrator{Method::kAdams, 5}, Integrator{Method::kAdams, 12, 0, 0},
                                         Integrator{Method::kStabilized, 2},
                                         Integrator{Method::kStabilized, 3}, Integrator{Method::kErkOpen, 3}),
                         testing::PrintToStringParamName());

/// Takes a quarter of a millisecond at each tick.
double Busy(double u) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(250);
  while (std::chrono::steady_clock::now() < end) {
  }
  return u;
}

TEST(RunProfileTest, AccountsForTheTimeOfTheRun) {
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  const auto& position =
      builder.AddFunction({"position"}, Uses(oscillator.state), [](const Vec<2>& x) { return x[0]; });
  auto& busy = builder.Add<SampledMap>("busy", {Busy, Sampled{Hz(100)}});
  builder.Connect(position, busy.u);
  builder.Connect(busy.y, oscillator.u);
  Simulator simulator(builder.Build(), {.profile = true});
  simulator.AddLog(Hz(100), {&oscillator.state});
  const auto begin = std::chrono::steady_clock::now();
  simulator.RunTo(1);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const RunProfile profile = simulator.Profile();
  EXPECT_GT(profile.total, 0.95 * wall.count());
  EXPECT_LE(profile.total, wall.count());
  ASSERT_FALSE(profile.calculations.empty());
  EXPECT_EQ(profile.calculations[0].path, "busy.y");
  EXPECT_EQ(profile.calculations[0].calls, 101);
  EXPECT_GE(profile.calculations[0].seconds, 101 * 250e-6);
  EXPECT_EQ(profile.Blocks()[0].path, "busy");
  EXPECT_GT(profile.integrator, 0);
  EXPECT_GT(profile.logs, 0);
  EXPECT_EQ(profile.waiting, 0);
  EXPECT_NE(profile.Text().find("101 calls"), std::string::npos) << profile.Text();
}

TEST(RunProfileTest, ProfilingChangesNoBit) {
  const auto end = [](bool profile) {
    PdLoop loop;
    Simulator simulator(loop.builder.Build(), {.profile = profile});
    simulator.context().Set(loop.cart.x, {1, 0});
    simulator.RunTo(0.5);
    return simulator.context().Save();
  };
  EXPECT_EQ(end(false), end(true));
}

TEST(RunProfileTest, MustBeAskedFor) {
  DiagramBuilder builder;
  builder.Add<Oscillator>("oscillator");
  const Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<RunError>([&] { static_cast<void>(simulator.Profile()); }, "SimulatorOptions::profile"));
}

}  // namespace tenon::run_memory_test
