#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::witness_test {

using ::testing::ElementsAre;

/// Notes the times at which its input crosses zero; has no continuous state.
struct Relay final : LeafSystem<Crossing> {
  explicit Relay(Crossing crossing) : LeafSystem(crossing) {}
  InputPort<double> u{this, "u"};
  Witness change{this, "change", params, Uses(u), [](double u) { return u; }};
  DiscreteState<std::vector<double>> times{this, "times"};
  Update<std::vector<double>> note{times, change, Uses(times, time),
                                   [](const std::vector<double>& times, double t) {
                                     std::vector<double> more = times;
                                     more.push_back(t);
                                     return more;
                                   }};
};

using WitnessTest = DiagramTest;

TEST_F(WitnessTest, DirectionsWithoutAnyState) {
  for (const Method method : kAllMethods) {
    DiagramBuilder fresh;
    auto& wave =
        fresh.AddFunction("wave", Uses(fresh.time), [](double t) { return std::sin(M_PI * t - 0.5); });
    auto& rising = fresh.Add<Relay>("rising", Crossing::kRising);
    auto& falling = fresh.Add<Relay>("falling", Crossing::kFalling);
    auto& both = fresh.Add<Relay>("both", Crossing::kBoth);
    for (auto* relay : {&rising, &falling, &both}) fresh.Connect(wave, relay->u);
    Simulator simulator(fresh.Build(), {.method = method, .max_step = 0.1});
    simulator.RunTo(4);
    const double first = 0.5 / M_PI;
    const auto near = [](double t) { return testing::DoubleNear(t, 1e-9); };
    EXPECT_THAT(simulator.context().Eval(rising.times), ElementsAre(near(first), near(first + 2)));
    EXPECT_THAT(simulator.context().Eval(falling.times), ElementsAre(near(first + 1), near(first + 3)));
    EXPECT_THAT(simulator.context().Eval(both.times),
                ElementsAre(near(first), near(first + 1), near(first + 2), near(first + 3)));
  }
}

TEST_F(WitnessTest, ManyBlocksMayFireAtOneInstant) {
  auto& ramp = builder.AddFunction("ramp", Uses(builder.time), [](double t) { return t - 0.5; });
  std::vector<Relay*> relays;
  for (int i = 0; i < 150; ++i) {
    relays.push_back(&builder.Add<Relay>("relay" + std::to_string(i), Crossing::kRising));
    builder.Connect(ramp, relays.back()->u);
  }
  Simulator simulator(builder.Build(), {.max_step = 0.2});
  simulator.RunTo(1);
  for (const Relay* relay : relays) EXPECT_EQ(simulator.context().Eval(relay->times).size(), 1);
}

/// A crossing exactly on, just before and just behind a tick fires once.
TEST_F(WitnessTest, CrossingsAroundTicksFireOnce) {
  struct Timer final : LeafSystem<double> {
    explicit Timer(double at) : LeafSystem(at) {}
    Witness due{this, "due", Crossing::kRising, Uses(time), &Timer::Left};
    DiscreteState<int> fired{this, "fired"};
    Update<int> count{fired, due, Uses(fired), [](int n) { return n + 1; }};

   private:
    double Left(double t) const { return t - params; }
  };
  for (const Method method : kAllMethods) {
    DiagramBuilder fresh;
    std::vector<const Timer*> timers;
    for (const double at :
         {0.5, 0.5 - 1e-16, 0.5 + 2e-16, 0.5 - 1e-12, 0.5 + 1e-12, 0.5 - 1e-9, 0.5 + 1e-9}) {
      timers.push_back(&fresh.Add<Timer>("timer" + std::to_string(timers.size()), at));
    }
    fresh.Add<Oscillator>("plant");
    fresh.Add<Counter>("ticks", Sampled{Hz(10)});
    Simulator simulator(fresh.Build(), {.method = method});
    simulator.RunTo(1);
    for (const Timer* timer : timers)
      EXPECT_EQ(simulator.context().Eval(timer->fired), 1) << timer->params - 0.5;
  }
}

TEST_F(WitnessTest, JumpsOfHeldValuesFireAtTheirTick) {
  auto& command = builder.AddFunction("command", Sampled{Hz(10)}, Uses(builder.time),
                                      [](double t) { return t > 0.25 && t < 0.55 ? 1.0 : -1.0; });
  auto& rising = builder.Add<Relay>("rising", Crossing::kRising);
  auto& falling = builder.Add<Relay>("falling", Crossing::kFalling);
  auto& both = builder.Add<Relay>("both", Crossing::kBoth);
  for (auto* relay : {&rising, &falling, &both}) builder.Connect(command, relay->u);
  Simulator simulator(builder.Build());
  simulator.RunTo(1);
  EXPECT_THAT(simulator.context().Eval(rising.times), ElementsAre(0.3));
  EXPECT_THAT(simulator.context().Eval(falling.times), ElementsAre(0.6));
  EXPECT_THAT(simulator.context().Eval(both.times), ElementsAre(0.3, 0.6));
}

TEST_F(WitnessTest, FirstSampleIsNoJump) {
  // The command is 1 from the start. Before its first tick it has no value; it is not 0.
  auto& relay = builder.Add<Relay>("relay", Crossing::kRising);
  builder.Connect(builder.AddFunction("one", Sampled{Hz(10)}, Uses(), [] { return 1.0; }), relay.u);
  EXPECT_TRUE(ValueAt(1, builder, relay.times).empty());
}

struct Flip final : LeafSystem<void> {
  DiscreteState<double> s{this, "s", 1.0};
  Update<double> disturb{s, Sampled{Seconds(1), 0.5}, Uses(s), [](double s) { return -s; }};
  Witness w{this, "w", Crossing::kBoth, Uses(s), [](double s) { return s; }};
  Update<double> flip{s, w, Uses(s), [](double s) { return -s; }};
};

TEST_F(WitnessTest, UpdateThatFlipsItsOwnWitnessIsOneEvent) {
  // After the update, the witness starts on its new side.
  auto& flip = builder.Add<Flip>("flip");
  EXPECT_EQ(ValueAt(1, builder, flip.s, {.max_events = 10}), 1);  // disturbed once, and flipped back once
}

/// Notes when a ramp and the input sum to more than 0.25: a witness that reads another witness and is read.
struct Ramp final : LeafSystem<void> {
  ContinuousState<double> x{this, {"x"}, 0.0};
  InputPort<double> u{this, {"u"}};
  TimeDerivative<double> dx{x, Uses(x), [](double) { return 1.0; }};
  Witness own{this, "own", Crossing::kRising, Uses(x), [](double x) { return x - 0.25; }};
  Witness sum{this, "sum", Crossing::kRising, Uses(own, u), [](double own, double u) { return own + u; }};
  OutputPort<double> y{this, {"y"}, Uses(sum), [](double sum) { return sum; }};
  DiscreteState<double> when{this, "when", -1.0};
  Update<double> note{when, sum, Uses(time), [](double t) { return t; }};
};

TEST_F(WitnessTest, AWitnessMayReadAnotherOneOfAnyBlock) {
  for (const Method method : kAllMethods) {
    DiagramBuilder fresh;
    auto& low = fresh.AddFunction("low", Uses(), [] { return -0.25; });
    auto& first = fresh.Add<Ramp>("first");
    auto& second = fresh.Add<Ramp>("second");
    fresh.Connect(low, first.u);
    fresh.Connect(first.y, second.u);
    Simulator simulator(fresh.Build(), {.method = method, .max_step = 0.1});
    simulator.RunTo(1);
    EXPECT_NEAR(simulator.context().Eval(first.when), 0.5, 1e-9);
    EXPECT_NEAR(simulator.context().Eval(second.when), 0.375, 1e-9) << "t - 0.25 + (t - 0.5)";
  }
}

}  // namespace tenon::witness_test
