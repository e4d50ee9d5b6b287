#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/signal_fault.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::signal_fault_test {

using ::testing::ElementsAre;
using Kind = SignalFaultKind;

/// y at ten ticks, 1 ms apart, with the inputs 10, 11, …
std::vector<double> Outputs(SignalFaultParams<> params) {
  TestRig<SignalFault<>> rig(params);
  std::vector<double> y;
  for (int n = 0; n < 10; ++n) y.push_back(rig.Fix(rig->u, 10 + n).Tick()[rig->y]);
  return y;
}

constexpr FaultSchedule kThirdToSixth{.start = 0.003, .duration = 0.003};  // ticks 3, 4, 5

TEST(SignalFaultTest, IsWhatItsKindSays) {
  EXPECT_THAT(Outputs({.kind = Kind::kDropOut, .schedule = kThirdToSixth}),
              ElementsAre(10, 11, 12, 0, 0, 0, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kStuck, .schedule = kThirdToSixth}),
              ElementsAre(10, 11, 12, 12, 12, 12, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kSpike, .schedule = kThirdToSixth, .size = 0.5}),
              ElementsAre(10, 11, 12, 13.5, 14, 15, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kSpike, .schedule = {.start = 0.003}, .size = 0.5, .period = 0.002}),
              ElementsAre(10, 11, 12, 13.5, 14, 15.5, 16, 17.5, 18, 19.5));
  EXPECT_THAT(Outputs({.kind = Kind::kOffset, .schedule = kThirdToSixth, .size = -3}),
              ElementsAre(10, 11, 12, 10, 11, 12, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kLoss, .schedule = kThirdToSixth, .size = 0.5}),
              ElementsAre(10, 11, 12, 6.5, 7, 7.5, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kLate, .schedule = kThirdToSixth, .samples = 2}),
              ElementsAre(10, 11, 12, 11, 12, 13, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kLost, .schedule = kThirdToSixth, .probability = 1}),
              ElementsAre(10, 11, 12, 12, 12, 12, 16, 17, 18, 19));
  EXPECT_THAT(Outputs({.kind = Kind::kLost, .schedule = kThirdToSixth, .probability = 0}),
              ElementsAre(10, 11, 12, 13, 14, 15, 16, 17, 18, 19));
}

TEST(SignalFaultTest, ActsFromTheFirstTickUnlessToldOtherwise) {
  EXPECT_THAT(Outputs({.kind = Kind::kStuck}), ElementsAre(10, 10, 10, 10, 10, 10, 10, 10, 10, 10));
  EXPECT_THAT(Outputs({.kind = Kind::kLate, .samples = 3}),
              ElementsAre(10, 10, 10, 10, 11, 12, 13, 14, 15, 16));
  EXPECT_THAT(Outputs({.kind = Kind::kDropOut, .schedule = {.duration = 0}}),
              ElementsAre(10, 11, 12, 13, 14, 15, 16, 17, 18, 19));
}

// In floating point, 0.1 s + 0.2 s is above 0.3 s. The tick at 0.3 s is not in the fault nevertheless.
TEST(SignalFaultTest, EndsAtItsTick) {
  TestRig<SignalFault<>> rig({.schedule = {.start = 0.1, .duration = 0.2}, .rate = Hz(10)});
  rig.Fix(rig->u, 1);
  std::vector<double> y;
  for (int n = 0; n < 5; ++n) y.push_back(rig.Tick()[rig->y]);
  EXPECT_THAT(y, ElementsAre(1, 0, 0, 1, 1));
}

TEST(SignalFaultTest, ActsOnACondition) {
  TestRig<SignalFault<>> rig({.kind = Kind::kStuck, .schedule = {.start = 0.002}});
  rig.Fix(rig->active, true).Fix(rig->u, 1).Tick();
  EXPECT_FALSE(rig[rig->acting]);
  EXPECT_EQ(rig.Fix(rig->u, 2).Tick()[rig->y], 2);
  EXPECT_EQ(rig.Fix(rig->u, 3).Tick()[rig->y], 2) << "by its schedule";
  EXPECT_TRUE(rig[rig->acting]);
  EXPECT_EQ(rig.Fix(rig->active, false).Fix(rig->u, 4).Tick()[rig->y], 4);
  EXPECT_EQ(rig.Fix(rig->active, true).Fix(rig->u, 5).Tick()[rig->y], 4) << "of the tick before";
}

TEST(SignalFaultTest, IsLostAsOftenAsItsProbability) {
  TestRig<SignalFault<>> rig({.kind = Kind::kLost, .probability = 0.3});
  rig.Fix(rig->u, -1).Tick();
  constexpr int kTicks = 10000;
  int lost = 0;
  for (int n = 0; n < kTicks; ++n) {
    const double before = rig[rig->y];
    const double y = rig.Fix(rig->u, n).Tick()[rig->y];
    EXPECT_TRUE(y == n || y == before);
    lost += y != n;
  }
  EXPECT_NEAR(lost, 0.3 * kTicks, 5 * std::sqrt(0.3 * 0.7 * kTicks));  // five standard deviations
}

struct Reading {
  Vec<2> angle = Vec<2>::Zero();
  int count = 0;
  bool valid = true;
  static FieldList Fields() {
    return {{"angle", &Reading::angle, "rad"}, {"count", &Reading::count}, {"valid", &Reading::valid}};
  }
};

Reading After(SignalFaultParams<Reading> params) {
  params.schedule.start = 0.001;
  TestRig<SignalFault<Reading>> rig(params);
  rig.Fix(rig->u, {Vec<2>(1, 2), 3, true}).Tick();
  return rig.Fix(rig->u, {Vec<2>(5, 6), 7, true}).Tick()[rig->y];
}

TEST(SignalFaultTest, TouchesRealNumbersAndThoseThatAreMeant) {
  Reading y = After({.kind = Kind::kOffset, .size = 0.5});
  EXPECT_THAT(y.angle, IsNear(Vec<2>(5.5, 6.5), 0));
  EXPECT_TRUE(y.count == 7 && y.valid);
  y = After({.kind = Kind::kOffset, .affected = {"angle.1"}, .size = 0.5});
  EXPECT_THAT(y.angle, IsNear(Vec<2>(5, 6.5), 0));
  y = After({.kind = Kind::kStuck, .affected = {"angle.0", "count"}});
  EXPECT_THAT(y.angle, IsNear(Vec<2>(1, 6), 0));
  EXPECT_TRUE(y.count == 3 && y.valid);
  y = After({.kind = Kind::kStuck});
  EXPECT_THAT(y.angle, IsNear(Vec<2>(1, 2), 0));
  EXPECT_EQ(y.count, 3);
  y = After({.kind = Kind::kDropOut});
  EXPECT_THAT(y.angle, IsNear(Vec<2>(0, 0), 0));
  EXPECT_TRUE(y.count == 0 && !y.valid);
}

TEST(SignalFaultTest, HoldsABool) {
  TestRig<SignalFault<bool>> rig({.kind = Kind::kLate, .samples = 2});
  rig.Fix(rig->u, true).Tick();
  EXPECT_TRUE(rig.Fix(rig->u, false).Tick()[rig->y]);
  EXPECT_TRUE(rig.Tick()[rig->y]);
  EXPECT_FALSE(rig.Tick()[rig->y]);
}

TEST(SignalFaultTest, CarriesVectorsOfARunTimeSize) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(3);
  using Fault = SignalFault<Eigen::VectorXd>;
  TestRig<Fault> rig({.kind = Kind::kLoss, .affected = {"z"}, .size = 1, .initial = zero});
  EXPECT_THAT(rig.Fix(rig->u, Eigen::Vector3d(1, 2, 3)).Tick()[rig->y], IsNear(Eigen::Vector3d(1, 2, 0), 0));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Fix(rig->u, Eigen::Vector2d(1, 2)).Tick(); }, "initial"));
  EXPECT_TRUE(Refuses<Fault>({.kind = Kind::kLoss}, "initial"));
}

// The run ends at the block where the NaN arises.
TEST(SignalFaultTest, ANanEndsTheRunWithItsName) {
  DiagramBuilder builder;
  auto& sine = builder.Add<Sine<>>("sine");
  auto& gain = builder.Add<Gain<>>("gain");
  builder.Connect(sine.y, gain.u);
  auto& fault = builder.Add<SignalFault<>>("broken_wire", {.kind = Kind::kNan, .schedule = {.start = 0.05}});
  builder.Insert(sine.y, fault.u, fault.y);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.049);
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(0.1); }, "broken_wire", "t = 0.05 s"));
}

TEST(SignalFaultTest, SizeAndScheduleAreSetInARun) {
  TestRig<SignalFault<>> rig({.kind = Kind::kOffset, .size = 1});
  rig.Fix(rig->u, 0);
  EXPECT_EQ(rig.Tick()[rig->y], 1);
  rig.Set(rig->size, 7);
  EXPECT_EQ(rig.Tick()[rig->y], 7);
  rig.Set(rig->schedule, {.start = 5});
  EXPECT_EQ(rig.Tick()[rig->y], 0);
}

TEST(SignalFaultTest, GoesOnFromASnapshot) {
  TestRig<SignalFault<Vec<2>>> rig({.kind = Kind::kLate, .samples = 2});
  rig.Fix(rig->u, {1, 10}).Tick().Fix(rig->u, {2, 20}).Tick().Fix(rig->u, {3, 30});
  auto context = rig.diagram().CreateContext();
  context->Restore(rig.context().Save());
  Simulator simulator(std::move(context));
  simulator.RunTo(0.003);
  EXPECT_THAT(simulator.context().Eval(rig->y), IsNear(Vec<2>(2, 20), 0));
}

TEST(SignalFaultTest, DoesNotAllocate) {
  for (const auto& [kind, name] : EnumNames(Kind{})) {
    if (kind == Kind::kNan) continue;
    TestRig<SignalFault<Vec<7>>> rig({.kind = kind, .affected = {"2", "3"}, .size = 1, .samples = 5});
    rig.Fix(rig->u, Vec<7>::Ones()).Tick();
    EXPECT_EQ(AllocationsOf([&] { rig.RunTo(0.1); }), 0) << name;
  }
}

TEST(SignalFaultTest, RefusesNonsense) {
  using Fault = SignalFault<Reading>;
  EXPECT_TRUE(Refuses<Fault>({.period = 1e-4}, "period"));
  EXPECT_TRUE(Refuses<Fault>({.samples = 0}, "samples"));
  EXPECT_TRUE(Refuses<Fault>({.probability = 1.5}, "probability"));
  EXPECT_TRUE(Refuses<Fault>({.affected = {"angles"}}, "'angles'"));
  EXPECT_TRUE(Refuses<Fault>({.kind = Kind::kNan, .affected = {"count"}}, "'count'"));
  EXPECT_TRUE(Refuses<SignalFault<int>>({.kind = Kind::kOffset, .size = 1}, "number"));
}

}  // namespace tenon::signal_fault_test
