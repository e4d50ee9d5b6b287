#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tenon::witness_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr Method kMethods[] = {Method::kErk, Method::kStabilized, Method::kDirk, Method::kBdf,
                               Method::kAdams};

/// Falls with g = 10 m/s² and loses part of its speed at each impact: v+ = -e v-. From rest at h0 the impacts
/// are at t_n = T (1 + 2 e + 2 e² + ... + 2 e^n), T = sqrt(2 h0 / g).
struct BallParams {
  double height = 5;  // m, so T = 1 s
  double restitution = 0.5;
};
class Ball final : public LeafSystem<BallParams> {
 public:
  using LeafSystem::LeafSystem;
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "height, velocity"}, Vec<2>(params.height, 0)};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -10); }};
  Witness impact{this, "impact", Crossing::kFalling, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Update<Vec<2>> bounce{x, impact, Uses(x), &Ball::Bounce};
  DiscreteState<std::vector<double>> times{this, "times"};
  Update<std::vector<double>> note{times, impact, Uses(times, time), &Ball::Note};

 private:
  Vec<2> Bounce(const Vec<2>& x) const { return {0, -params.restitution * x[1]}; }
  std::vector<double> Note(const std::vector<double>& times, double t) const {
    std::vector<double> more = times;
    more.push_back(t);
    return more;
  }
};

TEST(WitnessTest, BouncingBallFollowsTheClosedForm) {
  for (const Method method : kMethods) {
    for (const bool ticks : {false, true}) {
      DiagramBuilder builder;
      auto& ball = builder.Add<Ball>("ball");
      if (ticks) builder.Add<Counter>("ticks", Sampled{Hz(100)});  // an impact at t = 1 s falls on a tick
      const auto diagram = builder.Build();
      Simulator simulator(*diagram, {.method = method, .rtol = 1e-9, .atol = 1e-11});
      simulator.RunTo(2.9);
      const std::vector<double> times = simulator.context().Eval(ball.times);
      ASSERT_EQ(times.size(), 5);
      double expected = 1;
      for (std::size_t n = 0; n < times.size(); ++n) {
        EXPECT_NEAR(times[n], expected, 1e-6) << n;
        expected += 2 * std::pow(0.5, n + 1);
      }
      EXPECT_GE(simulator.context().Eval(ball.x)[0], 0);
    }
  }
}

TEST(WitnessTest, ZenoIsAnErrorThatNamesTheWitness) {
  DiagramBuilder builder;  // all impacts are before t = 3 s
  builder.Add<Ball>("ball");
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  EXPECT_THAT([&] { simulator.RunTo(4); },
              ThrowsMessage<RunError>(AllOf(HasSubstr("'ball.impact'"), HasSubstr("accumulate"))));
}

/// Notes the times at which sin(w t) crosses zero; has no continuous state.
struct WaveParams {
  double frequency;  // rad/s
  Crossing crossing;
};
class Wave final : public LeafSystem<WaveParams> {
 public:
  using LeafSystem::LeafSystem;
  Witness zero{this, "zero", params.crossing, Uses(time), &Wave::Value};
  DiscreteState<std::vector<double>> times{this, "times"};
  Update<std::vector<double>> note{times, zero, Uses(times, time), &Wave::Note};

 private:
  double Value(double t) const { return std::sin(params.frequency * t - 0.5); }
  std::vector<double> Note(const std::vector<double>& times, double t) const {
    std::vector<double> more = times;
    more.push_back(t);
    return more;
  }
};

TEST(WitnessTest, DirectionsWithoutAnyState) {
  for (const Method method : kMethods) {
    DiagramBuilder builder;
    auto& rising = builder.Add<Wave>("rising", WaveParams{M_PI, Crossing::kRising});
    auto& falling = builder.Add<Wave>("falling", WaveParams{M_PI, Crossing::kFalling});
    auto& both = builder.Add<Wave>("both", WaveParams{M_PI, Crossing::kBoth});
    const auto diagram = builder.Build();
    Simulator simulator(*diagram, {.method = method, .max_step = 0.1});
    simulator.RunTo(4);
    const double first = 0.5 / M_PI;
    const auto near = [](double t) { return testing::DoubleNear(t, 1e-9); };
    EXPECT_THAT(simulator.context().Eval(rising.times), ElementsAre(near(first), near(first + 2)));
    EXPECT_THAT(simulator.context().Eval(falling.times), ElementsAre(near(first + 1), near(first + 3)));
    EXPECT_THAT(simulator.context().Eval(both.times),
                ElementsAre(near(first), near(first + 1), near(first + 2), near(first + 3)));
  }
}

TEST(WitnessTest, ManyBlocksMayFireAtOneInstant) {
  DiagramBuilder builder;
  std::vector<const Wave*> waves;
  for (int i = 0; i < 150; ++i) {
    waves.push_back(&builder.Add<Wave>("wave" + std::to_string(i), WaveParams{1, Crossing::kRising}));
  }
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.max_step = 0.2});
  simulator.RunTo(1);
  for (const Wave* wave : waves) EXPECT_EQ(simulator.context().Eval(wave->times).size(), 1);
}

/// A crossing exactly on, just before and just behind a tick fires once.
TEST(WitnessTest, CrossingsAroundTicksFireOnce) {
  class Timer final : public LeafSystem<double> {
   public:
    explicit Timer(double at) : LeafSystem(at) {}
    Witness due{this, "due", Crossing::kRising, Uses(time), &Timer::Left};
    DiscreteState<int> fired{this, "fired"};
    Update<int> count{fired, due, Uses(fired), [](int n) { return n + 1; }};

   private:
    double Left(double t) const { return t - params; }
  };
  for (const Method method : kMethods) {
    DiagramBuilder builder;
    std::vector<const Timer*> timers;
    for (const double at :
         {0.5, 0.5 - 1e-16, 0.5 + 2e-16, 0.5 - 1e-12, 0.5 + 1e-12, 0.5 - 1e-9, 0.5 + 1e-9}) {
      timers.push_back(&builder.Add<Timer>("timer" + std::to_string(timers.size()), at));
    }
    builder.Add<Oscillator>("plant");
    builder.Add<Counter>("ticks", Sampled{Hz(10)});
    const auto diagram = builder.Build();
    Simulator simulator(*diagram, {.method = method});
    simulator.RunTo(1);
    for (const Timer* timer : timers)
      EXPECT_EQ(simulator.context().Eval(timer->fired), 1) << timer->params - 0.5;
  }
}

/// A relay: a sampled command jumps from -1 to 1, which no root finding inside a step can see.
class Relay final : public LeafSystem<Crossing> {
 public:
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

TEST(WitnessTest, JumpsOfHeldValuesFireAtTheirTick) {
  DiagramBuilder builder;
  auto& command = builder.AddFunction("command", Sampled{Hz(10)}, Uses(builder.time),
                                      [](double t) { return t > 0.25 && t < 0.55 ? 1.0 : -1.0; });
  auto& rising = builder.Add<Relay>("rising", Crossing::kRising);
  auto& falling = builder.Add<Relay>("falling", Crossing::kFalling);
  auto& both = builder.Add<Relay>("both", Crossing::kBoth);
  for (auto* relay : {&rising, &falling, &both}) builder.Connect(command, relay->u);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(1);
  EXPECT_THAT(simulator.context().Eval(rising.times), ElementsAre(0.3));
  EXPECT_THAT(simulator.context().Eval(falling.times), ElementsAre(0.6));
  EXPECT_THAT(simulator.context().Eval(both.times), ElementsAre(0.3, 0.6));
}

class SampledRelay final : public LeafSystem<void> {
 public:
  InputPort<double> u{this, "u"};
  Witness above{this, "above", Crossing::kRising, Uses(u), [](double u) { return u - 0.5; }};
  DiscreteState<int> fired{this, "fired"};
  Update<int> count{fired, above, Uses(fired), [](int n) { return n + 1; }};
};

TEST(WitnessTest, FirstSampleIsNoJump) {
  // The command is 1 from the start on; before its first tick there is none, rather than 0.
  DiagramBuilder builder;
  auto& relay = builder.Add<SampledRelay>("relay");
  builder.Connect(builder.AddFunction("one", Sampled{Hz(10)}, Uses(), [] { return 1.0; }), relay.u);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(relay.fired), 0);
}

class Flip final : public LeafSystem<void> {
 public:
  DiscreteState<double> s{this, "s", 1.0};
  Update<double> disturb{s, Sampled{Seconds(1), 0.5}, Uses(s), [](double s) { return -s; }};
  Witness w{this, "w", Crossing::kBoth, Uses(s), [](double s) { return s; }};
  Update<double> flip{s, w, Uses(s), [](double s) { return -s; }};
};

TEST(WitnessTest, UpdateThatFlipsItsOwnWitnessIsOneEvent) {
  // The witness starts anew on the side that the update has sent it to.
  DiagramBuilder builder;
  auto& flip = builder.Add<Flip>("flip");
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.max_events = 10});
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(flip.s), 1);  // disturbed once, and flipped back once
}

enum class Heater { kOff, kOn };

/// A thermostat with hysteresis, whose mode changes the dynamics: dT/dt = (heat ? 20 : 0) - T. Between 10 and
/// 15 degrees, heating takes ln(10 / 5) s and cooling ln(15 / 10) s.
class Room final : public LeafSystem<void> {
 public:
  Mode<Heater> heater{this, "heater", Heater::kOn};
  ContinuousState<double> x{this, {"temperature", "degC"}, 10.0};
  TimeDerivative<double> dx{x, Uses(x, heater),
                            [](double T, Heater h) { return (h == Heater::kOn ? 20 : 0) - T; }};
  Witness warm{this, "warm", Crossing::kRising, Uses(x), [](double T) { return T - 15; }};
  Witness cold{this, "cold", Crossing::kFalling, Uses(x), [](double T) { return T - 10; }};
  Update<Heater> off{heater, warm, Uses(), [] { return Heater::kOff; }};
  Update<Heater> on{heater, cold, Uses(), [] { return Heater::kOn; }};
};

TEST(WitnessTest, ThermostatSwitchesItsMode) {
  for (const Method method : kMethods) {
    DiagramBuilder builder;
    auto& room = builder.Add<Room>("room");
    const auto diagram = builder.Build();
    Simulator simulator(*diagram, {.method = method, .rtol = 1e-8, .atol = 1e-10});
    const double cycle = std::log(2) + std::log(1.5);
    simulator.RunTo(3 * cycle + std::log(2) - 0.01);
    EXPECT_EQ(simulator.context().Eval(room.heater), Heater::kOn);
    EXPECT_NEAR(simulator.context().Eval(room.x), 20 - 5 * std::exp(0.01), 1e-4);
    simulator.RunTo(3 * cycle + std::log(2) + 0.01);
    EXPECT_EQ(simulator.context().Eval(room.heater), Heater::kOff);
    EXPECT_NEAR(simulator.context().Eval(room.x), 15 * std::exp(-0.01), 1e-4);
  }
}

/// Notes when a ramp and the input together are above 0.25: a witness that reads another one, and is read.
class Ramp final : public LeafSystem<void> {
 public:
  ContinuousState<double> x{this, {"x"}, 0.0};
  InputPort<double> u{this, {"u"}};
  TimeDerivative<double> dx{x, Uses(x), [](double) { return 1.0; }};
  Witness own{this, "own", Crossing::kRising, Uses(x), [](double x) { return x - 0.25; }};
  Witness sum{this, "sum", Crossing::kRising, Uses(own, u), [](double own, double u) { return own + u; }};
  OutputPort<double> y{this, {"y"}, Uses(sum), [](double sum) { return sum; }};
  DiscreteState<double> when{this, "when", -1.0};
  Update<double> note{when, sum, Uses(time), [](double t) { return t; }};
};

TEST(WitnessTest, AWitnessMayReadAnotherOneOfAnyBlock) {
  for (const Method method : kMethods) {
    DiagramBuilder builder;
    auto& low = builder.AddFunction("low", Uses(), [] { return -0.25; });
    auto& first = builder.Add<Ramp>("first");
    auto& second = builder.Add<Ramp>("second");
    builder.Connect(low, first.u);
    builder.Connect(first.y, second.u);
    Simulator simulator(builder.Build(), {.method = method, .max_step = 0.1});
    simulator.RunTo(1);
    EXPECT_NEAR(simulator.context().Eval(first.when), 0.5, 1e-9);
    EXPECT_NEAR(simulator.context().Eval(second.when), 0.375, 1e-9) << "t - 0.25 + (t - 0.5)";
  }
}

}  // namespace
}  // namespace tenon::witness_test
