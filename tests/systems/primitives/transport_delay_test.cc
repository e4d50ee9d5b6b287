#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/transport_delay.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>
#include <vector>

namespace tenon::transport_delay_test {

using Params = TransportDelayParams<>;

/// The output of a delay with input u(t), at every millisecond.
template <class F>
std::vector<double> Delayed(const Params& params, F u, double end) {
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
  for (std::size_t i = 132; i < y.size(); ++i) {
    worst = std::max(worst, std::abs(y[i] - std::sin(w * (1e-3 * static_cast<double>(i) - tau))));
  }
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

TEST(TransportDelayTest, CarriesVectorsAndGoesOnFromASnapshot) {
  TestRig<TransportDelay<Vec<2>>> rig(
      {.delay = 0.25, .rate = Hz(10), .unit = "m, rad", .elements = "x, pitch"});
  for (int n = 0; n < 5; ++n) rig.Fix(rig->u, {n, 10 * n}).Tick();
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1.5, 15), 1e-13));
  EXPECT_EQ(rig->y.elements()[1].name, "pitch");
  auto context = rig.diagram().CreateContext();
  context->Restore(rig.context().Save());
  EXPECT_THAT(context->Eval(rig->y), IsNear(Vec<2>(1.5, 15), 1e-13));
}

TEST(TransportDelayTest, RefusesBadParameters) {
  for (const double bad : {0.0, -1.0, 0.0009, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<TransportDelay<>>({.delay = bad}, "delay"));
  EXPECT_TRUE(Refuses<TransportDelay<>>({.initial = test::kNan}, "initial"));
}

}  // namespace tenon::transport_delay_test
