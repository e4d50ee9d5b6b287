#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

namespace tenon::test_rig_test {

struct PdParams {
  double kp = 10;  // N/m
  double kd = 2;   // N s/m
  Rate rate = Hz(1000);
  void Validate() const { Demand(kp > 0, "kp must be positive"); }
};
struct Pd final : LeafSystem<PdParams> {
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  InputPort<double> ref{this, {"ref", "m"}};
  OutputPort<double> u{this, {"u", "N"}, Sampled{params.rate}, Uses(x, ref), &Pd::CalcU};

 private:
  double CalcU(const Vec<2>& x, double ref) const { return params.kp * (ref - x[0]) - params.kd * x[1]; }
};

/// A mass on a spring, with a count of its ticks and a speed that only a shared value knows.
struct Oscillator final : LeafSystem<void> {
  InputPort<double> force{this, {"force", "N"}};
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s"}, Vec<2>(1, 0)};
  DiscreteState<int> ticks{this, "ticks"};
  Shared<double> speed{this, "speed", Uses(x), [](const Vec<2>& x) { return std::abs(x[1]); }};
  OutputPort<Vec<2>> state{this, x};
  OutputPort<double> fast{this, "fast", Uses(speed), [](double speed) { return 2 * speed; }};
  Update<int> next{ticks, Sampled{Hz(10)}, Uses(ticks), [](int ticks) { return ticks + 1; }};

 private:
  TimeDerivative<Vec<2>> dx_{x, Uses(x, force), [](const Vec<2>& x, double force) -> Vec<2> {
                               return {x[1], force - x[0]};
                             }};
};

/// Two blocks in one.
struct Pair final : Subdiagram {
  Pair() {
    auto& first = Add<Pd>("first");
    Connect(x, first.x);
    Connect(ref, first.ref);
    Connect(first.u, u);
  }
  InputPort<Vec<2>> x{this, "x"};
  InputPort<double> ref{this, "ref"};
  OutputPort<double> u{this, "u"};
};

TEST(TestRigTest, HoldsSamplesUntilTheNextTick) {
  TestRig<Pd> rig({.kp = 3});
  rig.Fix(rig->x, {1, 0}).Fix(rig->ref, 2).Tick();
  rig.Fix(rig->ref, 1);
  EXPECT_EQ(rig[rig->u], 3);
  rig.Tick();
  EXPECT_EQ(rig.time(), 0.001);
  EXPECT_EQ(rig[rig->u], 0);
}

/// Counts its ticks where no context sees it.
struct Forgetful final : LeafSystem<void> {
  OutputPort<int> count{this, "count", Sampled{Hz(10)}, Uses(), [this] { return ++count_; }};

 private:
  mutable int count_ = 0;
};

TEST(TestRigTest, NamesWhatDoesNotRepeatItself) {
  TestRig<Forgetful> rig;
  EXPECT_TRUE(Throws<RunError>([&] { rig.CheckRepeats(1); }, "block.count"));
}

TEST(TestRigTest, ABlockThatRemembersInItsContextRepeatsItself) {
  TestRig<Oscillator> rig;
  rig.Fix(rig->force, 1).RunTo(0.25);
  rig.CheckRepeats(1);
  EXPECT_EQ(rig.time(), 0.25);
  EXPECT_EQ(rig[rig->ticks], 3);
}

TEST(TestRigTest, RefusesReadingBeforeTheFirstTick) {
  TestRig<Pd> rig;
  rig.Fix(rig->x, {1, 0}).Fix(rig->ref, 2);
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->u]; }, "block.u"));
}

TEST(TestRigTest, RefusesUnfixedInputs) {
  TestRig<Pd> rig;
  rig.Fix(rig->x, {1, 0});
  EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "block.ref"));
}

TEST(TestRigTest, PassesParameterErrorsOn) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<Pd> rig({.kp = -1}); }, "'block'", "kp"));
}

TEST(TestRigTest, EvaluatesContinuousBlocksWithoutATick) {
  TestRig<Oscillator> rig;
  rig.Fix(rig->force, 3).Set(rig->x, {0.5, -2}).Set(rig->ticks, 7);
  EXPECT_THAT(rig.Derivative(rig->x), IsNear(Vec<2>(-2, 2.5), 1e-15));
  EXPECT_EQ(rig[rig->speed], 2);
  EXPECT_EQ(rig[rig->fast], 4);
  EXPECT_EQ(rig[rig->ticks], 7);
  EXPECT_EQ(rig[rig->force], 3);
}

TEST(TestRigTest, IntegratesBetweenTicks) {
  TestRig<Oscillator> rig;
  rig.Fix(rig->force, 0).Tick();
  EXPECT_EQ(rig.time(), 0);
  EXPECT_EQ(rig[rig->ticks], 1);
  rig.Tick();
  EXPECT_EQ(rig.time(), 0.1);
  EXPECT_EQ(rig[rig->ticks], 2);
  EXPECT_THAT(rig[rig->state], IsNear(Vec<2>(std::cos(0.1), -std::sin(0.1)), 1e-9));
  rig.RunTo(1);
  EXPECT_EQ(rig[rig->ticks], 11);
  EXPECT_THAT(rig[rig->state], IsNear(Vec<2>(std::cos(1), -std::sin(1)), 1e-8));
}

TEST(TestRigTest, TakesSubdiagrams) {
  TestRig<Pair> rig;
  rig.Fix(rig->x, {0, 1}).Fix(rig->ref, 1).Tick();
  EXPECT_EQ(rig[rig->u], 8);
}

TEST(TestRigTest, RefusesTicksWithoutSampleTimes) {
  struct Still final : LeafSystem<void> {
    InputPort<double> u{this, "u"};
    OutputPort<double> y{this, "y", Uses(u), [](double u) { return -u; }};
  };
  TestRig<Still> rig;
  rig.Fix(rig->u, 1).Tick();
  EXPECT_EQ(rig[rig->y], -1);
  EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "no tick", "use RunTo"));
}

}  // namespace tenon::test_rig_test
