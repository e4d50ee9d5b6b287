#include <tenon/systems/primitives/adder.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <unsupported/Eigen/MatrixFunctions>

namespace tenon::simulator_test {

using ::testing::ElementsAre;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Single {
  double whole = 0;
  float part = 0;
  static FieldList Fields() { return {{"whole", &Single::whole}, {"part", &Single::part}}; }
};

/// A sampled float, a struct with a float, and states of both, which become NaN at t = 0.2 s.
struct Floats final : LeafSystem<int> {
  using LeafSystem::LeafSystem;
  float At(double t, int which) const { return which == params && t > 0.15 ? std::nanf("") : 1.0F; }
  OutputPort<float> number{this, "number", Sampled{Hz(10)}, Uses(time),
                           [this](double t) { return At(t, 0); }};
  OutputPort<Single> single{this, "single", Sampled{Hz(10)}, Uses(time), [this](double t) {
                              return Single{1, At(t, 1)};
                            }};
  DiscreteState<float> state{this, "state"};
  Update<float> next{state, Sampled{Hz(10)}, Uses(time), [this](double t) { return At(t, 2); }};
  DiscreteState<Single> both{this, "both"};
  Update<Single> next_both{both, Sampled{Hz(10)}, Uses(time), [this](double t) {
                             return Single{1, At(t, 3)};
                           }};
};

using SimulatorTest = DiagramTest;

TEST_F(SimulatorTest, NanInSinglePrecisionEndsARun) {
  const char* const names[] = {"'floats.number'", "'floats.single.part'", "'floats.state'",
                               "'floats.both.part'"};
  for (int i = 0; i < 4; ++i) {
    DiagramBuilder fresh;
    fresh.Add<Floats>("floats", i);
    Simulator simulator(fresh.Build());
    simulator.RunTo(0.1);
    EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(0.3); }, names[i], "t = 0.2 s"));
  }
}

TEST_F(SimulatorTest, ASourceWhoseDataEndIsToldThatStepsGoPastTheEnd) {
  auto& plant = builder.Add<Oscillator>("plant");
  builder.Connect(builder.AddFunction("data", Uses(builder.time),
                                      [](double t) {
                                        if (t > 1) throw std::out_of_range("no data");
                                        return 0.0;
                                      }),
                  plant.u);
  Simulator simulator(builder.Build());
  const auto run = [&] { simulator.RunTo(1); };
  EXPECT_TRUE(Throws<RunError>(run, "'data.output'", "after t = 1 s", "NextJump"));
}

// ---- Closed loops ----

/// x[n+1] = e^{AT} x[n] + ∫e^{As}B ds u[n], both from one exponential of [A B; 0 0] T.
TEST_F(SimulatorTest, ClosedLoopFollowsTheExactSampledSolution) {
  auto& plant = builder.Add<Oscillator>("plant", 3.0);
  auto& pd = builder.Add<Pd>("pd", {.kp = 4, .kd = 1, .rate = Hz(50)});
  auto& ref = builder.AddFunction("ref", Uses(builder.time), [](double t) { return t < 0.5 ? 0.0 : 0.2; });
  builder.Connect(plant.state, pd.x);
  builder.Connect(ref, pd.ref);
  builder.Connect(pd.u, plant.u);
  Simulator simulator(builder.Build(), {.rtol = 1e-10, .atol = 1e-12});
  const auto log = simulator.AddLog(Hz(50), {&plant.state, &pd.u});
  simulator.RunTo(2);

  Eigen::Matrix3d continuous = Eigen::Matrix3d::Zero();
  continuous << 0, 1, 0, -9, 0, 1, 0, 0, 0;
  const Eigen::Matrix3d step = Eigen::Matrix3d(continuous * 0.02).exp();
  ASSERT_EQ(log->rows(), 101);
  Eigen::Vector2d x(1, 0);
  for (int n = 0; n <= 100; ++n) {
    const double u = 4 * ((n < 25 ? 0.0 : 0.2) - x[0]) - x[1];
    EXPECT_NEAR(log->row(n)[1], x[0], 1e-8) << n;
    EXPECT_NEAR(log->row(n)[3], u, 1e-7) << n;
    x = (step * Eigen::Vector3d(x[0], x[1], u)).head<2>();
  }
}

TEST_F(SimulatorTest, StartBetweenTicksIsRefusedUnlessTheSampleIsGiven) {
  auto& plant = builder.Add<Oscillator>("plant");
  auto& pd = builder.Add<Pd>("pd", {.rate = Hz(10)});
  builder.Connect(plant.state, pd.x);
  builder.Connect(pd.u, plant.u);
  const auto context = builder.Build()->CreateContext();
  context->SetTime(0.15);
  Simulator refused(context->Clone());
  EXPECT_TRUE(Throws<RunError>([&] { refused.RunTo(1); }, "'pd.u'", "t = 0.15 s"));
  context->Set(pd.u, 0.0);
  Simulator given(context->Clone());
  EXPECT_EQ(given.AdvanceTo(1).time, 1);
  context->SetTime(0.2);  // a tick: everything runs
  Simulator at_tick(context->Clone());
  at_tick.Initialize();
  EXPECT_EQ(at_tick.context().Eval(pd.u), -10);
}

// ---- Ticks ----

TEST_F(SimulatorTest, ChainOfSampledBlocksHasNoHiddenDelay) {
  const Sampled at{Hz(100)};
  // The blocks are added in the reverse order of the data flow.
  auto& last = builder.Add<SampledMap>("last", {[](double u) { return u + 100; }, at});
  auto& middle = builder.Add<SampledMap>("middle", {[](double u) { return u + 10; }, at});
  auto& first = builder.Add<SampledMap>("first", {[](double u) { return u; }, at});
  auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return t; });
  builder.Connect(clock, first.u);
  builder.Connect(first.y, middle.u);
  builder.Connect(middle.y, last.u);
  Simulator simulator(builder.Build());
  for (const double t : {0.0, 0.01, 0.25}) {
    simulator.RunTo(t);
    EXPECT_EQ(simulator.context().Eval(last.y), t + 10 + 100);
  }
  simulator.RunTo(0.255);  // held
  EXPECT_EQ(simulator.context().Eval(last.y), 0.25 + 110);
}

TEST_F(SimulatorTest, ManyRatesTickExactly) {
  builder.Add<Oscillator>("plant");
  std::vector<const Counter*> counters;
  for (const double period : {1.0, 2.5, 5.0, 10.0, 260.0})
    counters.push_back(&builder.Add<Counter>("every_" + std::to_string(static_cast<int>(period * 10)),
                                             Sampled{Milliseconds(period)}));
  Simulator simulator(builder.Build(), {.rtol = 1e-4});
  simulator.RunTo(2);
  std::vector<int> counts;
  for (const Counter* counter : counters) counts.push_back(simulator.context().Eval(counter->n));
  EXPECT_THAT(counts, ElementsAre(2001, 801, 401, 201, 8));
  EXPECT_GT(simulator.statistics().smallest_step, 0.4e-3);  // the least distance of two ticks is 0.5 ms
  EXPECT_LT(simulator.statistics().steps, 2500);
}

TEST_F(SimulatorTest, ShortIntervalsBetweenTicksDoNotSpoilTheStepSize) {
  auto& plant = builder.Add<Oscillator>("plant");
  auto& force = builder.Add<Adder<double>>("force", {.weights = {1, 1}});
  AddRestarts(builder, "at_100", Hz(100), force.u[0]);
  AddRestarts(builder, "at_100_1", Hz(100.1), force.u[1]);  // 10 us apart at first
  builder.Connect(force.y, plant.u);
  Simulator simulator(builder.Build(), {.rtol = 1e-4, .atol = 1e-6});
  simulator.RunTo(10);
  EXPECT_LT(simulator.statistics().steps, 2030);  // one step for each of 2000 intervals
  EXPECT_NEAR(simulator.context().Eval(plant.x)[0], std::cos(10), 1e-6);
}

TEST_F(SimulatorTest, OffsetsDelayTheFirstTick) {
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10), 0.05});
  struct Late final : LeafSystem<void> {
    OutputPort<double> y{this, "y", -1.0, Sampled{Hz(10), 0.25}, Uses(time), [](double t) { return t; }};
  };
  auto& late = builder.Add<Late>("late");
  Simulator simulator(builder.Build());
  simulator.RunTo(0);
  EXPECT_EQ(simulator.context().Eval(counter.n), 0);
  EXPECT_EQ(simulator.next_tick_time(), 0.05);
  simulator.RunTo(0.2);
  EXPECT_EQ(simulator.context().Eval(counter.n), 2);  // at 0.05 and 0.15
  EXPECT_EQ(simulator.context().Eval(late.y), -1);    // the initial value
  simulator.RunTo(0.4);
  EXPECT_EQ(simulator.context().Eval(late.y), 0.35);
}

struct Swap final : LeafSystem<void> {
  DiscreteState<double> a{this, "a", 1.0};
  DiscreteState<double> b{this, "b", 2.0};
  Update<double> next_a{a, Sampled{Hz(10)}, Uses(b), [](double b) { return b; }};
  Update<double> next_b{b, Sampled{Hz(10)}, Uses(a), [](double a) { return a; }};
};

TEST_F(SimulatorTest, UpdatesCommitTogether) {
  TestRig<Swap> rig;
  rig.RunTo(0);
  EXPECT_EQ(rig[rig->a], 2);
  EXPECT_EQ(rig[rig->b], 1);
  rig.RunTo(0.1);
  EXPECT_EQ(rig[rig->a], 1);
  EXPECT_EQ(rig[rig->b], 2);
}

TEST_F(SimulatorTest, AdvanceIncludesTheTickAtItsEnd) {
  TestRig<Counter> rig(Sampled{Hz(10)});
  EXPECT_EQ(rig.RunTo(0.5)[rig->n], 6);
  EXPECT_EQ(rig.RunTo(0.5)[rig->n], 6) << "once only";
}

struct Loop {
  Loop() {
    DiagramBuilder builder;
    plant = &builder.Add<Oscillator>("plant", 5.0);
    pd = &builder.Add<Pd>("pd", {.rate = Hz(100)});
    builder.Connect(plant->state, pd->x);
    builder.Connect(pd->u, plant->u);
    builder.Add<Counter>("other", Sampled{Hz(30)});
    diagram = builder.Build();
  }
  Oscillator* plant;
  Pd* pd;
  std::shared_ptr<const Diagram> diagram;
};

TEST_F(SimulatorTest, AdvancesSplitAtTicksAreOneAdvanceBitForBit) {
  const Loop loop;
  Simulator whole(*loop.diagram), split(*loop.diagram), summed(*loop.diagram);
  whole.RunTo(1);
  for (int i = 0; i <= 100; ++i) split.RunTo(i / 100.0);
  double t = 0;
  for (int i = 0; i < 100; ++i) summed.RunTo(t += 0.01);  // misses ticks by rounding errors
  const Vec<2> x = whole.context().Eval(loop.plant->x);
  EXPECT_EQ(split.context().Eval(loop.plant->x), x);
  EXPECT_EQ(summed.context().Eval(loop.plant->x), x);
  EXPECT_EQ(summed.context().time(), 1);
  EXPECT_EQ(summed.statistics().steps, whole.statistics().steps);
}

TEST_F(SimulatorTest, AdvanceToBeforeLeavesTheTickForLater) {
  const Loop loop;
  Simulator whole(*loop.diagram), split(*loop.diagram);
  whole.RunTo(1);
  for (int i = 0; i <= 100; ++i) {
    const double time = i * 0.01;  // rounded
    ASSERT_FALSE(split.AdvanceToBefore(time).ended);
    EXPECT_DOUBLE_EQ(split.next_tick_time(), time);
    ASSERT_FALSE(split.AdvanceToBefore(time).ended);  // nothing happens
    if (i % 3 == 0) {
      const std::vector<std::byte> saved = split.context().Save();
      split.context().Restore(saved);
    }
  }
  const auto tick_due = split.context().Clone();
  split.RunTo(1);
  EXPECT_EQ(split.context().Save(), whole.context().Save());
  Simulator clone(tick_due->Clone());
  clone.RunTo(1);
  EXPECT_EQ(clone.context().Save(), whole.context().Save());
}

TEST_F(SimulatorTest, WhatIsSetBeforeATickIsWhatItReads) {
  const Loop loop;
  Simulator simulator(*loop.diagram);
  for (const double time : {0.0, 0.01, 0.05}) {
    ASSERT_FALSE(simulator.AdvanceToBefore(time).ended);
    simulator.context().Set(loop.plant->x, Vec<2>(time + 2, 0));
    simulator.RunTo(time);
    EXPECT_EQ(simulator.context().Eval(loop.pd->u), -10 * (time + 2));
  }
}

TEST_F(SimulatorTest, EveryMethodTakesEndsThatMissTicksByRounding) {
  const Loop loop;
  for (const Method method : kAllMethods) {
    Simulator simulator(*loop.diagram, {.method = method});
    double t = 0;
    for (int i = 0; i < 30; ++i) simulator.RunTo(t += 0.01);
    // CVODE begins behind each tick with a tiny step of its own.
    const bool multistep = method == Method::kBdf || method == Method::kAdams;
    EXPECT_GT(simulator.statistics().smallest_step, multistep ? 0 : 1e-6);
    EXPECT_LT(simulator.statistics().steps, 3000);
  }
}

TEST_F(SimulatorTest, BackwardsIsRefused) {
  const Loop loop;
  Simulator simulator(*loop.diagram);
  simulator.RunTo(1);
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(0.5); }, "t = 0.5 s", "t = 1 s"));
  for (const double t : {kNan, HUGE_VAL})
    EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(t); }, "give a finite time"));
}

// ---- What is computed when ----

/// Numbers of calls of the calculations of Counting.
struct Calls {
  int varying = 0, held = 0, shared = 0, derivative = 0;
};

struct CountingParams {
  Calls* calls;
};
struct Counting final : LeafSystem<CountingParams> {
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, "u", 0.0};
  ContinuousState<double> x{this, "x", 1.0};
  OutputPort<double> y{this, x};
  Shared<double> shared{this, "shared", Uses(x), &Counting::CalcShared};
  OutputPort<double> held{this, "held", Uses(u), &Counting::CalcHeld};
  OutputPort<double> varying{this, "varying", Uses(shared, u), &Counting::CalcVarying};
  TimeDerivative<double> dx{x, Uses(shared, u), &Counting::CalcDx};

 private:
  double CalcShared(double x) const { return ++params.calls->shared, 2 * x; }
  double CalcHeld(double u) const { return ++params.calls->held, u; }
  double CalcVarying(double s, double u) const { return ++params.calls->varying, s + u; }
  double CalcDx(double s, double u) const { return ++params.calls->derivative, -s + u; }
};

TEST_F(SimulatorTest, DerivativeEvaluationsComputeOnlyWhatVariesAndThatOnce) {
  Calls calls;
  auto& block = builder.Add<Counting>("block", {&calls});
  auto& other = builder.Add<Oscillator>("other");
  auto& controller = builder.Add<SampledMap>("controller", {[](double u) { return -u; }, {Hz(10)}});
  builder.Connect(block.y, controller.u);
  builder.Connect(controller.y, block.u);
  builder.Connect(block.held, other.u);
  Simulator simulator(builder.Build(), {.order = 5});  // evaluates at the end of a step
  simulator.RunTo(1);
  EXPECT_EQ(calls.held, 10);    // once per tick at which an integration starts
  EXPECT_EQ(calls.varying, 0);  // nobody wants it
  EXPECT_EQ(calls.derivative, simulator.statistics().evaluations);
  EXPECT_EQ(calls.shared, calls.derivative - 9);  // 9 intervals start with what the last one ended with
  EXPECT_EQ(simulator.context().Eval(block.held), simulator.context().Eval(controller.y));
  EXPECT_EQ(calls.held, 11);
}

TEST_F(SimulatorTest, FirstDerivativeAfterATickSkipsWhatTheTickComputed) {
  Calls calls;
  auto& block = builder.Add<Counting>("block", {&calls});
  auto& controller = builder.Add<SampledMap>("controller", {[](double u) { return -u; }, {Hz(10)}});
  builder.Connect(block.varying, controller.u);
  builder.Connect(controller.y, builder.Add<Oscillator>("other").u);
  Simulator simulator(builder.Build(), {.method = Method::kErkOpen, .fixed_step = 0.1});
  simulator.RunTo(1);
  EXPECT_EQ(calls.varying, 11);
  // A step of order 3 takes three evaluations, of which the first takes `shared` from the tick.
  EXPECT_EQ(simulator.statistics().evaluations, 30);
  EXPECT_EQ(calls.shared, 11 + 10 * 2);
}

TEST_F(SimulatorTest, WhatATickChangesIsComputedAgain) {
  // An output that depends on a discrete state, which the tick changes after the output was computed for a
  // log.
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10)});
  auto& twice = builder.AddFunction("twice", Uses(counter.count), [](int n) { return 2.0 * n; });
  auto& plant = builder.Add<Oscillator>("plant");
  builder.Connect(twice, plant.u);
  Simulator simulator(builder.Build());
  const auto log = simulator.AddLog(Hz(10), {&twice});
  simulator.RunTo(0.2);
  EXPECT_THAT(log->column("twice.output"), ElementsAre(0, 2, 4));
  EXPECT_EQ(simulator.context().Eval(twice), 6);
  EXPECT_EQ(simulator.context().EvalTimeDerivatives()[1], -simulator.context().Eval(plant.x)[0] + 6);
}

// ---- Events ----

struct UpdatedAtStart final : LeafSystem<void> {
  DiscreteState<int> n{this, "n", 5};
  ContinuousState<double> x{this, "x", 1.0};
  TimeDerivative<double> dx{x, Uses(), [] { return 0.0; }};
  Update<int> n0{n, AtStart{}, Uses(n), [](int n) { return n + 1; }};
  Update<double> x0{x, AtStart{}, Uses(n), [](int n) { return 10.0 * n; }};
  OutputPort<int> seen{this, "seen", Sampled{Hz(10)}, Uses(n), [](int n) { return n; }};
};

TEST_F(SimulatorTest, AtStartUpdatesRunBeforeTheFirstTickAndOnce) {
  auto& block = builder.Add<UpdatedAtStart>("block");
  Simulator simulator(builder.Build());
  simulator.Initialize();
  EXPECT_EQ(simulator.context().Eval(block.seen), 6);
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(block.n), 6);
  EXPECT_EQ(simulator.context().Eval(block.x), 50);  // both read the old n
}

TEST_F(SimulatorTest, AtStartUpdatesRunBeforeATickThatIsLeftForLater) {
  auto& block = builder.Add<UpdatedAtStart>("block");
  Simulator simulator(builder.Build());
  ASSERT_FALSE(simulator.AdvanceToBefore(0).ended);
  EXPECT_EQ(simulator.context().Eval(block.n), 6);
  EXPECT_THROW(simulator.context().Eval(block.seen), RunError);
  simulator.context().Set(block.n, 8);
  Simulator clone(simulator.context().Clone());
  clone.Initialize();
  EXPECT_EQ(clone.context().Eval(block.seen), 8);
  EXPECT_EQ(clone.context().Eval(block.n), 8);  // once
}

TEST_F(SimulatorTest, AtStartRefusesSamplesThatHaveNotRun) {
  struct Block final : LeafSystem<void> {
    InputPort<double> u{this, "u"};
    DiscreteState<double> s{this, "s"};
    Update<double> s0{s, AtStart{}, Uses(u), [](double u) { return u; }};
  };
  auto& block = builder.Add<Block>("block");
  builder.Connect(builder.AddFunction("one", Sampled{Hz(1)}, Uses(), [] { return 1.0; }), block.u);
  Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<RunError>([&] { simulator.Initialize(); }, "'one.output'", "t = 0 s"));
}

struct UpdatedEachStep final : LeafSystem<void> {
  InputPort<double> force{this, "force"};
  ContinuousState<Vec<2>> x{this, "x", Vec<2>(1, 0)};
  DiscreteState<int> steps{this, "steps"};
  TimeDerivative<Vec<2>> dx{x, Uses(x, force),
                            [](const Vec<2>& x, double f) { return Vec<2>(x[1], -x[0] + f); }};
  Update<int> count{steps, EachStep{}, Uses(steps), [](int n) { return n + 1; }};
  // Projection on the circle, as for a unit quaternion.
  Update<Vec<2>> project{x, EachStep{}, Uses(x), [](const Vec<2>& x) { return Vec<2>(x / x.norm()); }};
};

TEST_F(SimulatorTest, EachStepUpdatesRunAfterEveryStep) {
  for (const Method method : kAllMethods) {
    DiagramBuilder fresh;
    auto& block = fresh.Add<UpdatedEachStep>("block");
    AddRestarts(fresh, "end", Hz(1), block.force);  // the last step ends at 1 s
    // CVODE starts with tiny steps, and here it starts at each one.
    Simulator simulator(fresh.Build(), {.method = method, .rtol = 1e-4, .atol = 1e-6, .max_steps = 200000});
    simulator.RunTo(1);
    EXPECT_EQ(simulator.context().Eval(block.steps), simulator.statistics().steps);
    EXPECT_NEAR(simulator.context().Eval(block.x).norm(), 1, 1e-14);
    EXPECT_NEAR(simulator.context().Eval(block.x)[0], std::cos(1), 1e-2);
  }
}

struct Sawtooth final : LeafSystem<void> {
  ContinuousState<double> x{this, "x"};
  TimeDerivative<double> dx{x, Uses(), [] { return 1.0; }};
  Update<double> reset{x, Sampled{Seconds(0.5)}, Uses(), [] { return 0.0; }};
};

TEST_F(SimulatorTest, ContinuousStatesCanBeUpdatedAtTicks) {
  for (const Method method : kAllMethods) {
    DiagramBuilder fresh;
    auto& saw = fresh.Add<Sawtooth>("saw");
    Simulator simulator(fresh.Build(), {.method = method});
    const auto log = simulator.AddLog(Seconds(0.5), {&saw.x});
    simulator.RunTo(1.25);
    EXPECT_NEAR(log->row(1)[1], 0.5, 1e-9);  // a log shows what was before the updates
    EXPECT_NEAR(log->row(2)[1], 0.5, 1e-9);
    EXPECT_NEAR(simulator.context().Eval(saw.x), 0.25, 1e-9);
  }
}

TEST_F(SimulatorTest, SampledMonitorEndsTheRunWithItsReason) {
  struct Guard final : LeafSystem<void> {
    Monitor late{this, "late", Sampled{Hz(10)}, Uses(time),
                 [](double t) { return t > 0.35 ? Verdict("it is late") : Verdict(); }};
  };
  builder.Add<Guard>("guard");
  Simulator simulator(builder.Build());
  EXPECT_FALSE(simulator.AdvanceTo(0.3).ended);
  for (int i = 0; i < 2; ++i) {  // and it stays ended
    const RunStatus status = simulator.AdvanceTo(1);
    EXPECT_TRUE(status.ended);
    EXPECT_EQ(status.time, 0.4);
    EXPECT_EQ(status.reason, "guard.late: it is late");
  }
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "t = 0.4 s", "guard.late: it is late"));
}

struct Fall final : LeafSystem<void> {
  ContinuousState<double> height{this, "height", 1.0};
  TimeDerivative<double> d{height, Uses(), [] { return -1.0; }};
  Monitor floor{this, "floor", EachStep{}, Uses(height),
                [](double h) { return h < 0.5 ? Verdict("below 0.5 m") : Verdict(); }};
};

TEST_F(SimulatorTest, EachStepMonitorEndsTheRunInsideAnInterval) {
  auto& fall = builder.Add<Fall>("fall");
  Simulator simulator(builder.Build(), {.max_step = 0.01});
  const RunStatus status = simulator.AdvanceTo(2);
  EXPECT_TRUE(status.ended);
  EXPECT_EQ(status.reason, "fall.floor: below 0.5 m");
  EXPECT_NEAR(status.time, 0.5, 0.011);
  EXPECT_NEAR(simulator.context().Eval(fall.height), 1 - status.time, 1e-12);
}

TEST_F(SimulatorTest, EachStepMonitorIsAskedAtTheStart) {
  auto& fall = builder.Add<Fall>("fall");
  Simulator simulator(builder.Build());
  simulator.context().Set(fall.height, 0.4);
  const RunStatus status = simulator.AdvanceTo(2);
  EXPECT_TRUE(status.ended);
  EXPECT_EQ(status.time, 0);
  EXPECT_EQ(status.monitor, &fall.floor);
}

// A verdict ends the run only while the state stays as it is: after another state was set, the run goes on.
TEST_F(SimulatorTest, AnOldVerdictDoesNotReturn) {
  struct Slow final : LeafSystem<void> {
    ContinuousState<double> height{this, "height", 1.0};
    TimeDerivative<double> d{height, Uses(), [] { return -1.0; }};
    Monitor floor{this, "floor", Sampled{Hz(10)}, Uses(height),
                  [](double h) { return h < 0.5 ? Verdict("below 0.5 m") : Verdict(); }};
  };
  const auto goes_on = [](auto& block, DiagramBuilder& fresh) {
    Simulator simulator(fresh.Build(), {.max_step = 0.01});
    const RunStatus status = simulator.AdvanceTo(1);
    EXPECT_EQ(status.monitor, &block.floor);
    simulator.context().Set(block.height, 2.0);
    const RunStatus again = simulator.AdvanceTo(status.time + 1);
    EXPECT_FALSE(again.ended) << again.reason;
    EXPECT_EQ(again.monitor, nullptr);
  };
  DiagramBuilder by_step, by_sample;
  goes_on(by_step.Add<Fall>("fall"), by_step);
  goes_on(by_sample.Add<Slow>("slow"), by_sample);
}

TEST_F(SimulatorTest, RestoredRunGoesOnAfterItHadEnded) {
  struct Guard final : LeafSystem<void> {
    DiscreteState<bool> armed{this, "armed", true};
    Monitor late{this, "late", Sampled{Hz(10)}, Uses(time, armed),
                 [](double t, bool armed) { return armed && t > 0.35 ? Verdict("late") : Verdict(); }};
  };
  auto& guard = builder.Add<Guard>("guard");
  Simulator simulator(builder.Build());
  simulator.RunTo(0.2);
  const auto snapshot = simulator.context().Save();
  EXPECT_TRUE(simulator.AdvanceTo(1).ended);
  simulator.context().Restore(snapshot);
  simulator.context().Set(guard.armed, false);
  EXPECT_FALSE(simulator.AdvanceTo(1).ended);
  EXPECT_EQ(simulator.context().time(), 1);
}

TEST_F(SimulatorTest, LogsCanBeAddedUnderWay) {
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10)});
  Simulator simulator(builder.Build());
  simulator.RunTo(0.30000001);
  const auto log = simulator.AddLog(Hz(5), {&counter.count});
  simulator.RunTo(0.8);
  EXPECT_THAT(log->column("time"), ElementsAre(0.4, 0.6, 0.8));
  EXPECT_THAT(log->column("counter.n"), ElementsAre(4, 6, 8));
  EXPECT_EQ(simulator.context().Eval(counter.n), 9);
}

/// Ticks every 0.01 s; the one at 0.05 s takes 50 ms on the clock.
struct Stalls final : LeafSystem<void> {
  Publish stall{this, "stall", Sampled{Hz(100)}, Uses(time), [](double time) {
                  if (time != 0.05) return;
                  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
                  while (std::chrono::steady_clock::now() < end) continue;
                }};
};

TEST_F(SimulatorTest, ATickOnTimeIsNotMissed) {
  builder.Add<Counter>("counter", Sampled{Hz(100)});
  Simulator simulator(builder.Build(), {.real_time_rate = 10, .late_tolerance = 1e6});
  simulator.RunTo(0.1);
  simulator.RunTo(0.105);
  EXPECT_EQ(simulator.real_time().ticks, 10);
  EXPECT_EQ(simulator.real_time().missed, 0);
  EXPECT_EQ(simulator.real_time().missed_lateness, 0);
}

TEST_F(SimulatorTest, ATickAfterAStallIsMissed) {
  builder.Add<Stalls>("stalls");
  Simulator simulator(builder.Build(), {.real_time_rate = 10, .late_tolerance = 0.02});
  simulator.RunTo(0.1);
  // The five ticks behind it are due within 5 ms of the clock.
  const RealTimeStatistics& statistics = simulator.real_time();
  EXPECT_EQ(statistics.ticks, 10);
  EXPECT_GE(statistics.missed, 5);
  EXPECT_GE(statistics.worst_lateness, 0.049 - 1e-6);
  EXPECT_GT(statistics.worst_time, 0);
  EXPECT_EQ(statistics.missed_time, 0.1);
  EXPECT_GE(statistics.missed_lateness, 0.045 - 1e-6);
  EXPECT_EQ(statistics.lateness.count(), 10);
  EXPECT_GE(*statistics.lateness.Quantile(1), 0.049 * 0.99);
  EXPECT_GE(*statistics.compute.Quantile(1), 0.05 * 0.99) << "of the tick that stalls";
}

TEST_F(SimulatorTest, TheClockCanBeShiftedByAStall) {
  builder.Add<Stalls>("stalls");
  Simulator simulator(builder.Build(),
                      {.real_time_rate = 1, .late_policy = LatePolicy::kShift, .late_tolerance = 0.03});
  const auto begin = std::chrono::steady_clock::now();
  simulator.RunTo(0.1);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(elapsed.count(), 0.1 + 0.04 - 1e-6) << "nothing is caught up";
  EXPECT_GE(simulator.real_time().missed, 1);
  EXPECT_GE(simulator.real_time().worst_lateness, 0.04 - 1e-6);
}

TEST_F(SimulatorTest, AStallCanEndTheRun) {
  builder.Add<Stalls>("stalls");
  Simulator simulator(builder.Build(),
                      {.real_time_rate = 1, .late_policy = LatePolicy::kStop, .late_tolerance = 0.03});
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "t = 0.0", "real_time_rate", "late_policy"));
  EXPECT_EQ(simulator.real_time().missed, 1);
  EXPECT_EQ(simulator.real_time().missed_time, simulator.context().time());
}

TEST_F(SimulatorTest, TheClockDoesNotRunBackwards) {
  builder.Add<Counter>("counter", Sampled{Hz(100)});
  const auto diagram = builder.Build();
  EXPECT_TRUE(Throws<ParameterError>([&] { Simulator(*diagram, {.real_time_rate = -1}); }, "real_time_rate"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Simulator(*diagram, {.late_tolerance = -0.1}); }, "late_tolerance"));
  EXPECT_TRUE(Throws<ParameterError>([&] { Simulator(*diagram, {.real_time_rate = std::nan("")}); },
                                     "real_time_rate", "finite"));
}

// ---- Errors ----

TEST_F(SimulatorTest, SampledNanIsReportedWhereItArises) {
  auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return t; });
  auto& root = builder.Add<SampledMap>("root", {[](double t) { return std::sqrt(0.25 - t); }});
  auto& after = builder.Add<SampledMap>("after", {[](double u) { return u; }});
  builder.Connect(clock, root.u);
  builder.Connect(root.y, after.u);
  EXPECT_TRUE(RunFails(builder, "'root.y'", "t = 0.26 s"));
}

TEST_F(SimulatorTest, ContinuousNanIsReportedAtTheFirstPort) {
  auto& plant = builder.Add<Oscillator>("plant");
  auto& root = builder.AddFunction("root", Uses(builder.time), [](double t) { return std::sqrt(0.25 - t); });
  auto& gain = builder.Add<Map>("gain", [](double u) { return 2 * u; });
  builder.Connect(root, gain.u);
  builder.Connect(gain.y, plant.u);
  const auto diagram = builder.Build();
  for (const Method method : kAllMethods) {
    Simulator simulator(*diagram, {.method = method});
    EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "'root.output'", "t = 0.25"));
  }
}

TEST_F(SimulatorTest, HeldNanIsReportedAtTheFirstPort) {
  // A continuous output that uses held values is computed once per tick, when a derivative first reads it.
  auto& plant = builder.Add<Oscillator>("plant");
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10)});
  auto& bad = builder.AddFunction("bad", Uses(counter.count), [](int n) { return n == 3 ? kNan : 0.0; });
  builder.Connect(bad, plant.u);
  EXPECT_TRUE(RunFails(builder, "'bad.output'", "t = 0.2 s"));
}

TEST_F(SimulatorTest, InfinityIsReportedWhenItReachesADerivative) {
  auto& plant = builder.Add<Oscillator>("plant");
  auto& pole =
      builder.AddFunction("pole", Sampled{Hz(4)}, Uses(builder.time), [](double t) { return 1 / (0.5 - t); });
  auto& bound = builder.AddFunction("bound", Sampled{Hz(1)}, Uses(), [] { return HUGE_VAL; });  // legitimate
  builder.Connect(pole, plant.u);
  Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "'pole.output'", "t = 0.5 s"));
  EXPECT_EQ(simulator.context().Eval(bound), HUGE_VAL);
}

struct CountFlushes final : LogSink {
  void Row(std::span<const double>) override { ++rows; }
  void Flush() override { flushed_rows = rows; }
  int rows = 0, flushed_rows = 0;
};

TEST_F(SimulatorTest, LogsAreFlushedAfterAnError) {
  auto& bad = builder.AddFunction("bad", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    if (t > 0.45) throw std::runtime_error("no");
    return t;
  });
  Simulator simulator(builder.Build());
  const auto sink = std::make_shared<CountFlushes>();
  simulator.AddLog(Hz(10), {&bad}, {sink});
  EXPECT_THROW(simulator.RunTo(1), RunError);
  EXPECT_EQ(sink->flushed_rows, 5);
}

TEST_F(SimulatorTest, AMonitorOfTheSimulatorEndsTheRun) {
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  const auto diagram = builder.Build();
  Simulator simulator(diagram);
  simulator.AddMonitor([&](Context& context) -> Verdict {
    if (context.Eval(oscillator.state)[0] < 0) return "it swings back";
    return {};
  });
  const RunStatus status = simulator.AdvanceTo(3);
  EXPECT_TRUE(status.ended);
  EXPECT_EQ(status.reason, "monitor: it swings back");
  EXPECT_NEAR(status.time, 1.6, 0.2);
  Simulator at_start(diagram);
  at_start.AddMonitor([](Context&) -> Verdict { return "never begin"; });
  EXPECT_EQ(at_start.AdvanceTo(1).time, 0);
}

TEST_F(SimulatorTest, AMonitorMayNotChangeTheContext) {
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  Simulator simulator(builder.Build());
  simulator.AddMonitor([&](Context& context) -> Verdict {
    context.Set(oscillator.x, {0, 0});
    return {};
  });
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "a monitor changed the context"));
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator.AddMonitor({}); }, "AddMonitor"));
}

// A calculation may have a reference to the context in which it runs.
TEST_F(SimulatorTest, ACalculationMayNotChangeTheContext) {
  for (const bool ticks : {false, true}) {
    DiagramBuilder fresh;
    auto& oscillator = fresh.Add<Oscillator>("oscillator");
    Context* own = nullptr;
    const auto change = [&](double t) {
      if (own != nullptr && t > 0.2) own->Set(oscillator.x, {0, 0});
      return t;
    };
    auto& clock = fresh.AddFunction("clock", Uses(fresh.time), change);
    if (ticks) {
      auto& map = fresh.Add<SampledMap>("map", {[](double u) { return u; }, {Hz(10)}});
      fresh.Connect(clock, map.u);
    } else {
      fresh.Connect(clock, oscillator.u);
    }
    Simulator simulator(fresh.Build());
    own = &simulator.context();
    EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "changed the context")) << ticks;
    EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "cannot continue")) << ticks;
  }
}

TEST_F(SimulatorTest, AnErrorWithoutATextIsAnError) {
  builder.Add<Oscillator>("oscillator");
  Simulator simulator(builder.Build());
  simulator.AddMonitor([](Context&) -> Verdict { throw std::runtime_error(""); });
  EXPECT_THROW(simulator.RunTo(1), std::runtime_error);
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "cannot continue"));
}

TEST_F(SimulatorTest, AbsurdOptionsAndNullAreRefused) {
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  const auto diagram = builder.Build();
  for (const SimulatorOptions& options :
       {SimulatorOptions{.rtol = 1e300}, SimulatorOptions{.atol = std::numeric_limits<double>::infinity()},
        SimulatorOptions{.method = static_cast<Method>(99)},
        SimulatorOptions{.method = static_cast<Method>(-1)}})
    EXPECT_TRUE(Throws<ParameterError>([&] { Simulator(*diagram, options); }, "SimulatorOptions"));
  EXPECT_TRUE(Throws<ParameterError>([] { Simulator(std::unique_ptr<Context>()); }, "context is null"));
  EXPECT_TRUE(Throws<ParameterError>([] { Simulator(std::shared_ptr<const Diagram>()); }, "diagram is null"));
  Simulator simulator(diagram);
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator.AddLog(Hz(1), {nullptr}); }, "null"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { simulator.AddLog(Hz(1), {&oscillator.state}, {nullptr}); }, "null"));
  for (const double bad : {kNan, std::numeric_limits<double>::infinity()})
    EXPECT_TRUE(Throws<RunError>([&] { simulator.context().SetTime(bad); }, "finite time"));
  EXPECT_TRUE(Throws<Error>([&] { simulator.AddLog(Hz(1), {&oscillator.state})->column("x"); }, "advance"));
}

}  // namespace tenon::simulator_test
