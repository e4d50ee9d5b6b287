#include <tenon/systems/io/slow.h>
#include <tenon/systems/primitives/adder.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <atomic>
#include <thread>

namespace tenon::slow_test {

/// A planner at 100 Hz: the square of its input plus the number of its calculations, which it remembers, as a
/// plan of 3 numbers; and a controller at 1 kHz that follows the plan.
struct PlannerParams {
  double fails_at = 1e9;  ///< input at which a calculation throws
  Rate rate = Hz(100);
};
class Planner : public LeafSystem<PlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, {"u"}};
  InputPorts<double> others{this, {"other"}, 2};
  Scratch<double> count{this, "count"};
  Workspace<std::vector<double>> tools{this, "tools", {1, 2}};
  OutputPort<std::vector<double>> plan{this,
                                       {"plan"},
                                       std::vector<double>(3),
                                       Sampled{params.rate},
                                       Uses(time, u, others, count, tools),
                                       &Planner::CalcPlan};
  OutputPort<double> command{
      this, {"command"}, Sampled{Hz(1000)}, Uses(plan, u), [](const std::vector<double>& p, double u_now) {
        return p[1] - u_now;
      }};
  mutable std::atomic<bool> hold{false};     ///< a calculation waits while it is set
  mutable std::atomic<int> calculations{0};  ///< that have ended

 private:
  void CalcPlan(const double& t, const double& u_now, const Inputs<double>& others_now, double& count_now,
                std::vector<double>& tools_now, std::vector<double>* out) const {
    hold.wait(true);
    if (u_now >= params.fails_at) throw std::runtime_error("no plan");
    tools_now[0] = u_now;
    (*out)[0] = t;
    (*out)[1] = tools_now[0] * u_now;
    (*out)[2] = (count_now += others_now[0] + others_now[1]);
    ++calculations;
  }
};
using SlowPlanner = Slow<Planner, &Planner::plan>;

/// The planner with inputs that change at every tick, and x' = command, so that the plan matters.
struct Loop {
  DiagramBuilder builder;
  SlowPlanner& planner;
  const OutputPort<double>& u =
      builder.AddFunction("u", Uses(builder.time), [](double t) { return InputAt(t); });
  explicit Loop(const SlowOptions& slow, double fails_at = 1e9)
      : planner(builder.Add<SlowPlanner>("planner", {.block = {.fails_at = fails_at}, .slow = slow})) {
    builder.Connect(u, planner.u);
    for (std::size_t i : {0, 1}) builder.Connect(u, planner.others[i]);
  }
  static double InputAt(double t) { return 1 + std::sin(10 * t); }
};

std::shared_ptr<MemoryLog> AddLog(Simulator& simulator, const Loop& loop) {
  const SlowPlanner& planner = loop.planner;
  return simulator.AddLog(Hz(1000), {&planner.plan, &planner.command, &planner.age, &planner.result});
}
/// Times, plans, commands and ages at all ticks.
std::vector<double> Values(const MemoryLog& log) {
  std::vector<double> all;
  for (std::size_t i = 0; i < log.rows(); ++i) all.insert(all.end(), log.row(i).begin(), log.row(i).end());
  return all;
}
std::vector<double> Record(Simulator& simulator, const Loop& loop, double end = 0.3) {
  const auto log = AddLog(simulator, loop);
  simulator.RunTo(end);
  return Values(*log);
}

/// Runs from tick to tick to `end`, and waits after every `n`-th for the calculation in the thread.
void RunAndWait(Simulator& simulator, const Loop& loop, double end, int n = 1) {
  Context& context = simulator.context();
  for (int k = 0; context.time() < end; ++k) {
    simulator.RunTo(std::round(1000 * context.time() + 1) / 1000);
    const auto& job = context.Eval(loop.planner.job);
    if (k % n != 0 || !job.busy || !job.in_thread) continue;
    while (!context.Eval(loop.planner.worker).done()) std::this_thread::yield();
  }
}

TEST(SlowTest, HasTheResultOfTheInputsOneDurationAgo) {
  for (const double time : {0.003, 0.01, 0.0125, 0.04}) {
    Loop loop({.time = time});
    Simulator simulator(loop.builder.Build());
    // The oracle counts ticks: a start, and the result so many ticks later.
    const int ticks = static_cast<int>(std::ceil(time * 1000 - 1e-9));
    int start = 0, running = -1;
    double count = 2 * Loop::InputAt(0), held_count = count;
    for (int k = 0; k <= 300; ++k) {
      simulator.RunTo(k / 1000.0);
      if (running >= 0 && k == running + ticks) start = running, held_count = count, running = -1;
      if (k > 0 && running < 0 && k % 10 == 0) running = k, count += 2 * Loop::InputAt(k / 1000.0);
      const double s = start / 1000.0;
      const auto& plan = simulator.context().Eval(loop.planner.plan);
      ASSERT_EQ(plan[0], s) << k << " with " << time;
      ASSERT_EQ(plan[1], Loop::InputAt(s) * Loop::InputAt(s));
      ASSERT_NEAR(plan[2], held_count, 1e-12);
      ASSERT_EQ(simulator.context().Eval(loop.planner.age), k / 1000.0 - s);
      ASSERT_EQ(simulator.context().Eval(loop.planner.command), plan[1] - Loop::InputAt(k / 1000.0));
    }
  }
}

TEST(SlowTest, WithoutDurationIsTheBlockItself) {
  Loop loop({});
  Simulator simulator(loop.builder.Build());
  TestRig<Planner> rig;
  for (int k = 0; k <= 50; ++k) {
    const double t = k / 1000.0, u = Loop::InputAt(t);
    simulator.RunTo(t);
    rig.Fix(rig->u, u).Fix(rig->others[0], u).Fix(rig->others[1], u).RunTo(t);
    EXPECT_EQ(simulator.context().Eval(loop.planner.plan), rig[rig->plan]);
    EXPECT_EQ(simulator.context().Eval(loop.planner.command), rig[rig->command]);
  }
}

TEST(SlowTest, DrawnDurationsFollowTheSeed) {
  const auto run = [](std::uint64_t seed) {
    Loop loop({.time = 0.01, .jitter = 0.008});
    Simulator simulator(loop.builder.Build(), {.seed = seed});
    return Record(simulator, loop);
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(SlowTest, ContinuesFromCloneAndSnapshotWithinACalculation) {
  const SlowOptions slow{.time = 0.012, .jitter = 0.006};
  Loop loop(slow);
  const auto diagram = loop.builder.Build();
  Simulator simulator(diagram, {.seed = 5});
  for (simulator.RunTo(0.06); !simulator.context().Eval(loop.planner.job).busy;)
    simulator.RunTo(simulator.next_tick_time());
  Simulator clone(simulator.context().Clone()), restored(diagram, {.seed = 5});
  restored.context().Restore(simulator.context().Save());
  const std::vector<double> whole = Record(simulator, loop);
  EXPECT_EQ(Record(clone, loop), whole);
  EXPECT_EQ(Record(restored, loop), whole);
}

TEST(SlowTest, AMeasuredRunIsRepeatedByItsDurations) {
  Loop loop({.measured = true, .record = true});
  Simulator simulator(loop.builder.Build());
  const std::vector<double> measured = Record(simulator, loop);
  const Recording<double> durations = simulator.context().Eval(loop.planner.job).durations;
  EXPECT_GT(durations.size(), 10u);
  EXPECT_GT(durations.back().value, 0);
  Loop again({.record = true, .replay = durations});
  Simulator replay(again.builder.Build());
  EXPECT_EQ(Record(replay, again), measured);
}

/// A run in a thread whose calculations end when the test says so.
TEST(SlowTest, ThreadTakesTheResultOnceItIsThere) {
  Loop loop({.thread = true, .record = true});
  Simulator simulator(loop.builder.Build());
  const SlowPlanner& planner = loop.planner;
  simulator.RunTo(0);
  EXPECT_EQ(simulator.context().Eval(planner.plan)[0], 0) << "the first result is waited for";
  planner.hold = true;
  simulator.RunTo(0.033);  // a calculation starts at 10 ms
  EXPECT_EQ(simulator.context().Eval(planner.age), 0.033);
  planner.hold = false;
  planner.hold.notify_all();
  while (!simulator.context().Eval(planner.worker).done()) std::this_thread::yield();
  simulator.RunTo(0.034);
  EXPECT_EQ(simulator.context().Eval(planner.plan)[0], 0.01);
  EXPECT_EQ(simulator.context().Eval(planner.plan)[1], Loop::InputAt(0.01) * Loop::InputAt(0.01));
  EXPECT_EQ(simulator.context().Eval(planner.age), 0.034 - 0.01);
  const Recording<double>& durations = simulator.context().Eval(planner.job).durations;
  ASSERT_EQ(durations.size(), 2u);
  EXPECT_EQ(durations[1].time, 0.01);
  EXPECT_EQ(durations[1].value, 0.034 - 0.01);
}

TEST(SlowTest, ThreadUnderStressIsRepeatedBitForBit) {
  Loop loop({.thread = true, .record = true});
  Simulator simulator(loop.builder.Build());
  const auto log = AddLog(simulator, loop);
  RunAndWait(simulator, loop, 3, 50);
  const Recording<double> durations = simulator.context().Eval(loop.planner.job).durations;
  EXPECT_GT(durations.size(), 50u);
  Loop again({.replay = durations});
  Simulator replay(again.builder.Build());
  EXPECT_EQ(Record(replay, again, 3), Values(*log));
}

TEST(SlowTest, ThreadOfACloneStartsAnewAndAllEnd) {
  Loop loop({.thread = true, .record = true});
  Simulator simulator(loop.builder.Build());
  simulator.RunTo(0.005);
  loop.planner.hold = true;
  simulator.RunTo(0.015);
  const std::vector<std::byte> saved = simulator.context().Save();
  Simulator clone(simulator.context().Clone());
  clone.RunTo(0.02);
  loop.planner.hold = false;
  loop.planner.hold.notify_all();
  RunAndWait(clone, loop, 0.022);
  EXPECT_EQ(clone.context().Eval(loop.planner.plan)[0], 0.02);
  RunAndWait(simulator, loop, 0.031);
  EXPECT_EQ(simulator.context().Eval(loop.planner.plan)[0], 0.03);
  simulator.context().Restore(saved);  // while no calculation runs
  RunAndWait(simulator, loop, 0.022);
  EXPECT_EQ(simulator.context().Eval(loop.planner.plan)[0], 0.02);
  simulator.RunTo(0.03);  // a calculation runs while the contexts end
}

TEST(SlowTest, RethrowsAtTheTickWithTheNameOfTheBlock) {
  for (const bool thread : {false, true}) {
    Loop loop({.time = 0.004, .thread = thread}, 1.5);
    Simulator simulator(loop.builder.Build());
    EXPECT_TRUE(Throws<RunError>([&] { RunAndWait(simulator, loop, 3); }, "planner.result", "no plan"));
    EXPECT_EQ(simulator.context().time(), thread ? 0.061 : 0.06) << "the input is 1.5 after 52 ms";
  }
}

TEST(SlowTest, TickDoesNotAllocate) {
  for (const bool thread : {false, true}) {
    Loop loop({.time = 0.004, .jitter = 0.002, .thread = thread});
    Simulator simulator(loop.builder.Build());
    simulator.RunTo(0.1);
    EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.2); }), 0);
  }
}

TEST(SlowTest, RefusesWrongOptions) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { Loop loop({.time = 0.001, .jitter = 0.002}); }, "planner", "jitter"));
  EXPECT_TRUE(Throws<ParameterError>([] { Loop loop({.time = -1}); }, "planner", "time_s"));
  EXPECT_TRUE(Throws<ParameterError>([] { Loop loop({.rate = Hz(150)}); }, "planner", "150 Hz"));
}

}  // namespace tenon::slow_test
