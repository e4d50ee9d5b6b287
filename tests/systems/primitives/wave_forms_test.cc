// Signals of time.

#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/pulse.h>
#include <tenon/systems/primitives/saturation.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/systems/primitives/table.h>
#include <tenon/systems/primitives/trajectory.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::wave_forms_test {

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
  EXPECT_NEAR(ValueAt(0.123 + 37 * 0.037, builder, integral.y), 0.37, 1e-12);
}

TEST(PulseTest, RefusesWhatIsNoPulse) {
  EXPECT_TRUE(Refuses<Pulse<>>({.start = test::kInfinity}, "start"));
  EXPECT_TRUE(Refuses<Pulse<>>({.width = 0}, "width"));
  EXPECT_TRUE(Refuses<Pulse<>>({.width = 1, .period = 1}, "period"));
}

using KinkTest = DiagramTest;

TEST_F(KinkTest, ALimitedSineIsIntegratedWithinTheTolerance) {
  auto& sine = builder.Add<Sine<>>("sine");
  auto& limit = builder.Add<Saturation<>>("limit", {.lower = -0.5, .upper = 0.5});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(sine.y, limit.u);
  builder.Connect(limit.y, integral.u);
  EXPECT_NEAR(ValueAt(M_PI, builder, integral.y), 2 * (1 - std::cos(M_PI / 6)) + M_PI / 3, 1e-5);
}

TEST_F(KinkTest, ATableOfTimeIsIntegratedWithinTheTolerance) {
  auto& clock = builder.AddFunction({"clock"}, Uses(builder.time), [](double t) { return t; });
  auto& table = builder.Add<Table<>>("table", {.u = {1, 1.3, 2.7, 3}, .y = {0, 2, -1, 0}});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(clock, table.u);
  builder.Connect(table.y, integral.u);
  EXPECT_NEAR(ValueAt(4, builder, integral.y), 0.3 + 0.7 - 0.15, 1e-5);
}

TEST_F(KinkTest, ATrajectoryEndsStepsAtItsTimes) {
  auto& trajectory = builder.Add<Trajectory<>>("trajectory", {.times = {1, 1.5, 2.5}, .values = {0, 1, -1}});
  auto& integral = builder.Add<Integrator<>>("integral");
  builder.Connect(trajectory.ddy, integral.u);
  EXPECT_NEAR(ValueAt(3, builder, integral.y), 0, 1e-9);  // from rest to rest
}

TEST(SineTest, HasItsDerivatives) {
  TestRig<Sine<>> rig({.amplitude = 2, .angular_frequency = 3, .phase = 0.5, .offset = 1, .unit = "m"});
  for (const double t : {0.0, 0.4, 2.0}) {
    rig.context().SetTime(t);
    EXPECT_NEAR(rig[rig->y], 1 + 2 * std::sin(3 * t + 0.5), 1e-15);
    EXPECT_NEAR(rig[rig->dy], 6 * std::cos(3 * t + 0.5), 1e-15);
    EXPECT_NEAR(rig[rig->ddy], -18 * std::sin(3 * t + 0.5), 1e-14);
  }
}

TEST(SineTest, MakesACircle) {
  TestRig<Sine<Vec<2>>> rig({.phase = {M_PI / 2, 0}, .unit = "m", .elements = "x, y"});
  rig.context().SetTime(0.3);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(std::cos(0.3), std::sin(0.3)), 1e-15));
  EXPECT_EQ(rig->dy.elements()[1].name, "y");
}

TEST(TrajectoryTest, ReproducesACubic) {
  const auto p = [](double t) -> Vec<2> { return {1 + t * t * t, 2 * t - t * t}; };
  const auto v = [](double t) -> Vec<2> { return {3 * t * t, 2 - 2 * t}; };
  const auto a = [](double t) -> Vec<2> { return {6 * t, -2}; };
  TrajectoryParams<Vec<2>> params{.start_velocity = v(-1), .end_velocity = v(3)};
  for (const double t : {-1.0, 0.0, 0.5, 2.0, 3.0}) {
    params.times.push_back(t);
    params.values.push_back(p(t));
  }
  TestRig<Trajectory<Vec<2>>> rig(params);
  for (const double t : {-1.0, -0.3, 0.0, 0.2, 0.5, 1.7, 2.0, 2.9, 3.0}) {
    rig.context().SetTime(t);
    EXPECT_THAT(rig[rig->y], IsNear(p(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig->dy], IsNear(v(t), 1e-13)) << t;
    EXPECT_THAT(rig[rig->ddy], IsNear(a(t), 1e-12)) << t;
  }
}

TEST(TrajectoryTest, IsTwiceContinuouslyDifferentiable) {
  TestRig<Trajectory<>> rig({.times = {0, 1, 1.5, 3, 4}, .values = {0, 2, -1, 0.5, 3}});
  for (const double knot : {1.0, 1.5, 3.0}) {
    rig.context().SetTime(knot - 1e-9);
    const double y = rig[rig->y], dy = rig[rig->dy], ddy = rig[rig->ddy];
    rig.context().SetTime(knot + 1e-9);
    EXPECT_NEAR(rig[rig->y], y, 1e-6);
    EXPECT_NEAR(rig[rig->dy], dy, 1e-6);
    EXPECT_NEAR(rig[rig->ddy], ddy, 1e-6);
  }
  rig.context().SetTime(1.5);
  EXPECT_EQ(rig[rig->y], -1);
}

TEST(TrajectoryTest, StartsAndEndsAtRest) {
  TestRig<Trajectory<>> rig({.times = {1, 3}, .values = {0, 4}, .unit = "m"});  // 4 (3 r^2 - 2 r^3)
  const double points[][4] = {{0, 0, 0, 0}, {1, 0, 0, 6}, {2, 2, 3, 0}, {3, 4, 0, -6}, {5, 4, 0, 0}};
  for (const auto& [t, y, dy, ddy] : points) {
    rig.RunTo(t);
    EXPECT_NEAR(rig[rig->y], y, 1e-14) << t;
    EXPECT_NEAR(rig[rig->dy], dy, 1e-14) << t;
    EXPECT_NEAR(rig[rig->ddy], ddy, 1e-14) << t;
  }
}

TEST(TrajectoryTest, RefusesBadPoints) {
  EXPECT_TRUE(Refuses<Trajectory<>>({}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0}, .values = {0}}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 1}, .values = {0}}, "values"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 2, 1}, .values = {0, 0, 0}}, "times"));
  EXPECT_TRUE(Refuses<Trajectory<>>({.times = {0, 1}, .values = {0, test::kNan}}, "finite"));
  EXPECT_TRUE(
      Refuses<Trajectory<>>({.times = {0, 1}, .values = {0, 1}, .end_velocity = test::kNan}, "finite"));
}

}  // namespace tenon::wave_forms_test
