#include <tenon/systems/primitives/jittered_delay.h>
#include <tenon/tests/testing/block_test.h>

#include <algorithm>
#include <vector>

namespace tenon::jittered_delay_test {

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

TEST(JitteredDelayTest, WithoutDelayItIsAConnection) {
  EXPECT_EQ(ImpulseThrough({.delay = 0}, 3), (std::vector<double>{1, 0, 0}));
}

TEST(JitteredDelayTest, DelaysByWholePeriods) {
  EXPECT_EQ(ImpulseThrough({.delay = 0.002}, 5), (std::vector<double>{0, 0, 1, 0, 0}));
}

TEST(JitteredDelayTest, BetweenTicksTheImpulseIsShared) {
  const std::vector<double> out = ImpulseThrough({.delay = 0.0014}, 5);
  EXPECT_NEAR(out[1], 0.6, 1e-12);
  EXPECT_NEAR(out[2], 0.4, 1e-12);
  EXPECT_EQ(out[0] + out[3] + out[4], 0);
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

TEST(JitteredDelayTest, GoesOnFromASnapshot) {
  TestRig<JitteredDelay<>> rig({.delay = 0.003, .jitter = 0.002});
  for (int n = 0; n < 5; ++n) rig.Fix(rig->u, n).Tick();
  const auto clone = rig.context().Clone();
  rig.Tick().Tick();
  Simulator simulator(clone->Clone());
  simulator.RunTo(0.006);
  EXPECT_EQ(simulator.context().Eval(rig->y), rig[rig->y]);
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

}  // namespace tenon::jittered_delay_test
