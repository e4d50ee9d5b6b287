// Blocks that delay or hold a signal.

#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/jittered_delay.h>
#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/systems/primitives/transport_delay.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::delays_test {

TEST(UnitDelayTest, DelaysByOneSample) {
  TestRig<UnitDelay<>> rig({.initial = -1, .rate = Hz(100)});
  EXPECT_EQ(rig.Fix(rig->u, 1).Tick()[rig->y], -1);
  EXPECT_EQ(rig.Fix(rig->u, 2).Tick()[rig->y], 1);
  EXPECT_EQ(rig.Fix(rig->u, 3).Tick()[rig->y], 2);
  EXPECT_EQ(rig.time(), 0.02);
}

TEST(UnitDelayTest, CarriesAnything) {
  TestRig<UnitDelay<std::string>> rig({.initial = "none"});
  EXPECT_EQ(rig[rig->y], "none");
  EXPECT_EQ(rig.Fix(rig->u, "stance").Tick()[rig->y], "none");
  EXPECT_EQ(rig.Tick()[rig->y], "stance");
}

TEST(SampleDelayTest, DelaysByItsSamples) {
  for (const int samples : {1, 2, 5}) {
    TestRig<SampleDelay<Vec<2>>> rig({.samples = samples, .initial = {-1, -1}});
    for (int n = 0; n < 20; ++n) {
      rig.Fix(rig->u, {10 * n, n}).Tick();
      const Vec<2> expected = n < samples ? Vec<2>(-1, -1) : Vec<2>(10 * (n - samples), n - samples);
      EXPECT_EQ(rig[rig->y], expected) << samples << " samples, tick " << n;
    }
  }
}

TEST(SampleDelayTest, RefusesLessThanOneSample) {
  for (const int bad : {0, -3}) EXPECT_TRUE(Refuses<SampleDelay<>>({.samples = bad}, "samples"));
}

TEST(ZeroOrderHoldTest, SamplesAFunctionOfTime) {
  DiagramBuilder builder;
  auto& ramp = builder.AddFunction("ramp", Uses(builder.time), [](double t) { return t; });
  auto& hold = builder.Add<ZeroOrderHold<>>("hold", {.rate = Hz(4)});
  builder.Connect(ramp, hold.u);
  Simulator simulator(builder.Build());
  for (const double t : {0.0, 0.1, 0.25, 0.4, 0.99}) {
    simulator.RunTo(t);
    EXPECT_EQ(simulator.context().Eval(hold.y), std::floor(t * 4) / 4);
  }
}

/// The output of a delay with input u(t), at every millisecond.
template <class F>
std::vector<double> Delayed(const TransportDelayParams<>& params, F u, double end) {
  DiagramBuilder builder;
  auto& input = builder.AddFunction("u", Uses(builder.time), u);
  auto& delay = builder.Add<TransportDelay<>>("delay", params);
  builder.Connect(input, delay.u);
  Simulator simulator(builder.Build());
  std::vector<double> y;
  for (int i = 0; 1e-3 * i < end; ++i) {
    simulator.RunTo(1e-3 * i);
    y.push_back(simulator.context().Eval(delay.y));
  }
  return y;
}

TEST(TransportDelayTest, DelaysARampExactly) {
  for (const double tau : {0.05, 0.0721, 0.1}) {  // at 20 Hz: one period, between, two
    const auto y = Delayed(
        {.delay = tau, .initial = -1, .rate = Hz(20)}, [](double t) { return 3 + 2 * t; }, 0.5);
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double t = 1e-3 * static_cast<double>(i);
      if (std::abs(t - tau) < 1e-9) continue;  // it jumps
      EXPECT_NEAR(y[i], t < tau ? -1 : 3 + 2 * (t - tau), 1e-13) << "delay " << tau << ", t " << t;
    }
  }
}

TEST(TransportDelayTest, IsWithinItsBoundOfACurve) {
  const double h = 0.02, w = 5, tau = 0.131;
  const auto y = Delayed(
      {.delay = tau, .rate = Hz(50)}, [=](double t) { return std::sin(w * t); }, 1);
  double worst = 0;
  for (std::size_t i = 132; i < y.size(); ++i)
    worst = std::max(worst, std::abs(y[i] - std::sin(w * (1e-3 * static_cast<double>(i) - tau))));
  EXPECT_LE(worst, h * h / 8 * w * w);
  EXPECT_GE(worst, 0.9 * h * h / 8 * w * w) << "the bound is sharp";
}

TEST(TransportDelayTest, BreaksLoops) {
  // y' = -y(t - 1), y = 1 before: 1 - t up to t = 1, then 1 - t + (t - 1)^2 / 2 up to t = 2.
  DiagramBuilder builder;
  auto& delay = builder.Add<TransportDelay<>>("delay", {.delay = 1, .initial = 1, .rate = Hz(1000)});
  auto& integrator = builder.Add<Integrator<>>("y", {.initial = 1});
  auto& minus = builder.Add<Gain<>>("minus", {.gain = -1});
  builder.Connect(delay.y, minus.u);
  builder.Connect(minus.y, integrator.u);
  builder.Connect(integrator.y, delay.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(1);
  EXPECT_NEAR(simulator.context().Eval(integrator.y), 0, 1e-6);
  simulator.RunTo(1.5);
  EXPECT_NEAR(simulator.context().Eval(integrator.y), 1 - 1.5 + 0.125, 1e-6);
}

TEST(TransportDelayTest, CarriesVectors) {
  TestRig<TransportDelay<Vec<2>>> rig(
      {.delay = 0.25, .rate = Hz(10), .unit = "m, rad", .elements = "x, pitch"});
  for (int n = 0; n < 5; ++n) rig.Fix(rig->u, {n, 10 * n}).Tick();
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1.5, 15), 1e-13));
  EXPECT_EQ(rig->y.elements()[1].name, "pitch");
}

TEST(TransportDelayTest, RefusesBadParameters) {
  for (const double bad : {0.0, -1.0, 0.0009, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<TransportDelay<>>({.delay = bad}, "delay"));
  EXPECT_TRUE(Refuses<TransportDelay<>>({.initial = test::kNan}, "initial"));
}

/// The output of a delay whose input is 1 at the first tick and 0 afterwards.
std::vector<double> ImpulseThrough(const JitteredDelayParams<>& params, int ticks) {
  TestRig<JitteredDelay<>> rig(params);
  std::vector<double> out;
  for (int n = 0; n < ticks; ++n) {
    rig.Fix(rig->u, n == 0 ? 1 : 0).Tick();
    out.push_back(rig[rig->y]);
  }
  return out;
}

TEST(JitteredDelayTest, DelaysByPeriodsAndSharesWhatArrivesBetweenTicks) {
  using ::testing::ElementsAre, ::testing::DoubleNear;
  EXPECT_THAT(ImpulseThrough({.delay = 0}, 3), ElementsAre(1, 0, 0));
  EXPECT_THAT(ImpulseThrough({.delay = 0.002}, 5), ElementsAre(0, 0, 1, 0, 0));
  EXPECT_THAT(ImpulseThrough({.delay = 0.0014}, 5),
              ElementsAre(0, DoubleNear(0.6, 1e-12), DoubleNear(0.4, 1e-12), 0, 0));
}

/// Compares with a receiver that is simulated in fine steps: y is the mean of its value over a tick.
TEST(JitteredDelayTest, IsTheMeanOfWhatTheReceiverHolds) {
  constexpr double kDelay = 0.0021, kJitter = 0.0018, kPeriod = 0.001;
  constexpr int kTicks = 200, kParts = 10'000;
  const JitteredDelayParams<> params{.delay = kDelay, .jitter = kJitter, .initial = 7};
  TestRig<JitteredDelay<>> rig(params);
  std::vector<double> sent, arrives;
  RandomStream same(rig.context().seed(), rig->random.path());
  int overtaken = 0;
  for (int n = 0; n < kTicks; ++n) {
    sent.push_back(n % 7 - 3);
    arrives.push_back(n * kPeriod + kDelay + kJitter * same.Uniform(-1, 1));
    overtaken += n > 0 && arrives[static_cast<std::size_t>(n)] < arrives[static_cast<std::size_t>(n - 1)];
    rig.Fix(rig->u, sent.back()).Tick();
    double mean = 0;
    for (int part = 0; part < kParts; ++part) {
      const double time = (n + (part + 0.5) / kParts) * kPeriod;
      double held = params.initial;
      for (int m = std::max(0, n - 6); m <= n; ++m)
        if (arrives[static_cast<std::size_t>(m)] <= time) held = sent[static_cast<std::size_t>(m)];
      mean += held / kParts;
    }
    EXPECT_NEAR(rig[rig->y], mean, 2e-3) << "tick " << n;
  }
  EXPECT_GT(overtaken, 5);
}

TEST(JitteredDelayTest, CarriesVectorsOfAnySize) {
  TestRig<JitteredDelay<Eigen::VectorXd>> rig(
      JitteredDelayParams<Eigen::VectorXd>{.delay = 0.0005, .initial = Eigen::VectorXd::Zero(3)});
  rig.Fix(rig->u, Eigen::Vector3d(2, 4, 6)).Tick();
  EXPECT_THAT(rig[rig->y], IsNear(Eigen::VectorXd(Eigen::Vector3d(1, 2, 3)), 1e-15));
}

TEST(JitteredDelayTest, DoesNotAllocate) {
  TestRig<JitteredDelay<Eigen::VectorXd>> rig(
      {.delay = 0.003, .jitter = 0.002, .initial = Eigen::VectorXd::Zero(8)});
  rig.Fix(rig->u, Eigen::VectorXd::Ones(8)).Tick();
  EXPECT_EQ(AllocationsOf([&] { rig.RunTo(1); }), 0);
}

TEST(JitteredDelayTest, RefusesMessagesFromTheFuture) {
  EXPECT_TRUE(Refuses<JitteredDelay<>>({.delay = 1e-3, .jitter = 2e-3}, "jitter"));
  EXPECT_TRUE(Refuses<JitteredDelay<>>({.delay = 11}, "delay"));
}

}  // namespace tenon::delays_test
