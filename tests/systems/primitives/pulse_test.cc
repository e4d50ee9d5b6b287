#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/pulse.h>
#include <tenon/systems/primitives/saturation.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/systems/primitives/table.h>
#include <tenon/systems/primitives/trajectory.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::pulse_test {

TEST(PulseTest, IsAStepAPulseOrASquareWave) {
  const auto at = [](PulseParams<> params, double t) {
    TestRig<Pulse<>> rig(params);
    rig.context().SetTime(t);
    return rig[rig->y];
  };
  EXPECT_EQ(at({.low = -1, .start = 2}, 1.9), -1);
  EXPECT_EQ(at({.low = -1, .start = 2}, 2), 1);
  EXPECT_EQ(at({.start = 2, .width = 0.5}, 2.5), 0);
  for (int n = 0; n < 1000; n += 37) {
    const PulseParams<> wave{.start = 0.1, .width = 0.3, .period = 0.7};
    EXPECT_EQ(at(wave, 0.1 + n * 0.7), 1) << n;
    EXPECT_EQ(at(wave, 0.1 + n * 0.7 + 0.3), 0) << n;
  }
}

TEST(PulseTest, DeclaresItsEdges) {
  TestRig<Pulse<>> rig({.start = 1, .width = 0.25, .period = 2});
  for (const auto& [t, next] : {std::pair{0.0, 1.0}, {1.0, 1.25}, {1.25, 3.0}, {2.0, 3.0}, {3.1, 3.25}}) {
    rig.context().SetTime(t);
    EXPECT_EQ(rig[rig->next_edge], next) << t;
  }
  TestRig<Pulse<>> step({.start = 1});
  step.context().SetTime(1);
  EXPECT_EQ(step[step->next_edge], kNever);
}

TEST(PulseTest, IsIntegratedExactly) {
  DiagramBuilder builder;
  auto& pulse = builder.Add<Pulse<>>("pulse", {.start = 0.123, .width = 0.01, .period = 0.037});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(pulse.y, integral.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.123 + 37 * 0.037);
  EXPECT_NEAR(simulator.context().Eval(integral.y), 0.37, 1e-12);
}

TEST(PulseTest, RefusesWhatIsNoPulse) {
  EXPECT_TRUE(Refuses<Pulse<>>({.start = test::kInfinity}, "start"));
  EXPECT_TRUE(Refuses<Pulse<>>({.width = 0}, "width"));
  EXPECT_TRUE(Refuses<Pulse<>>({.width = 1, .period = 1}, "period"));
}

// ---- Kinks and bends of other blocks, which steps of the integrator do not span ----

TEST(KinkTest, ALimitedSineIsIntegratedWithinTheTolerance) {
  DiagramBuilder builder;
  auto& sine = builder.Add<Sine<>>("sine");
  auto& limit = builder.Add<Saturation<>>("limit", {.lower = -0.5, .upper = 0.5});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(sine.y, limit.u);
  builder.Connect(limit.y, integral.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(M_PI);
  EXPECT_NEAR(simulator.context().Eval(integral.y), 2 * (1 - std::cos(M_PI / 6)) + M_PI / 3, 1e-5);
}

TEST(KinkTest, ATableOfTimeIsIntegratedWithinTheTolerance) {
  DiagramBuilder builder;
  auto& clock = builder.AddFunction({"clock"}, Uses(builder.time), [](double t) { return t; });
  auto& table = builder.Add<Table<>>("table", {.u = {1, 1.3, 2.7, 3}, .y = {0, 2, -1, 0}});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(clock, table.u);
  builder.Connect(table.y, integral.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(4);
  EXPECT_NEAR(simulator.context().Eval(integral.y), 0.3 + 0.7 - 0.15, 1e-5);
}

TEST(KinkTest, ATrajectoryEndsStepsAtItsTimes) {
  DiagramBuilder builder;
  auto& trajectory = builder.Add<Trajectory<>>("trajectory", {.times = {1, 1.5, 2.5}, .values = {0, 1, -1}});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(trajectory.ddy, integral.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(3);
  EXPECT_NEAR(simulator.context().Eval(integral.y), 0, 1e-9);  // from rest to rest
}

}  // namespace tenon::pulse_test
