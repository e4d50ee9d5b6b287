#include <tenon/systems/framework/block/parameter.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <vector>

namespace tenon::parameter_test {

/// Limits of the force of Servo.
struct Limits {
  double low = -5, high = 5;
  static FieldList Fields() { return {{"low", &Limits::low, "N"}, {"high", &Limits::high, "N"}}; }
};
struct ServoParams {
  double kp = 10;      // N/m
  Limits limits = {};  // N
  Rate rate = Hz(100);
  void Validate() const {
    Demand(kp > 0, "kp must be positive");
    Demand(limits.low < limits.high, "limits.low must be below limits.high");
  }
};
class Servo final : public LeafSystem<ServoParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  Parameter<double> kp{this, {"kp", "N/m"}, params.kp, "stiffness"};
  Parameter<double> low{this, {"low", "N"}, params.limits.low};
  Parameter<double> high{this, {"high", "N"}, params.limits.high};
  Parameter<double> kd{this, {"kd", "N s/m"}, 2.0, "damping, no member of params"};
  OutputPort<double> u{this,
                       {"u", "N"},
                       Sampled{params.rate},
                       Uses(x, kp, kd, low, high),
                       [](const Vec<2>& x, double kp, double kd, double low, double high) {
                         return std::min(std::max(-kp * x[0] - kd * x[1], low), high);
                       }};
};
class Bounded final : public LeafSystem<Limits> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<Limits> limits{this, {"limits"}, params};
  OutputPort<double> width{
      this, {"width", "N"}, Uses(limits), [](const Limits& l) { return l.high - l.low; }};
};

struct Loop {
  DiagramBuilder builder;
  Servo* servo;
  Cart* cart;
  explicit Loop(const ServoParams& params = {})
      : servo(&builder.Add<Servo>("servo", params)), cart(&builder.Add<Cart>("cart")) {
    builder.Connect(cart->state, servo->x);
    builder.Connect(servo->u, cart->force);
  }
};

std::vector<double> End(std::unique_ptr<Context> context, const Cart& cart) {
  context->Set(cart.x, {1, 0});
  Simulator simulator(std::move(context));
  simulator.RunTo(1);
  return simulator.context().EvalDoubles(cart.x);
}

TEST(ParameterTest, StartsWithWhatParamsHold) {
  TestRig<Servo> rig({.kp = 3});
  EXPECT_EQ(rig[rig->kp], 3);
  rig.Fix(rig->x, {1, 0}).Tick();
  EXPECT_EQ(rig[rig->u], -3);
}

TEST(ParameterTest, ChangesInTheMiddleOfARun) {
  Loop loop;
  Simulator simulator(loop.builder.Build());
  simulator.context().Set(loop.cart->x, {0.1, 0});
  simulator.RunTo(0.005);
  EXPECT_EQ(simulator.context().Eval(loop.servo->u), -1);
  simulator.context().Set(loop.servo->kp, 20);
  EXPECT_EQ(simulator.context().Eval(loop.servo->u), -1) << "held until its tick";
  simulator.RunTo(0.01);
  EXPECT_NEAR(simulator.context().Eval(loop.servo->u), -2, 0.02);
}

TEST(ParameterTest, ASetValueGivesTheBitsOfOneThatWasBuilt) {
  Loop loop;
  const auto diagram = loop.builder.Build();
  auto context = diagram->CreateContext();
  context->Set(loop.servo->kp, 17);
  Loop built({.kp = 17});
  EXPECT_EQ(End(std::move(context), *loop.cart), End(built.builder.Build()->CreateContext(), *built.cart));
}

TEST(ParameterTest, SettingRunsValidateWithAllPresentValues) {
  TestRig<Servo> rig;
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->kp, -1); }, "'block.kp'"));
  EXPECT_EQ(rig[rig->kp], 10) << "nothing is changed";
  rig.Set(rig->high, 2);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->low, 3); }, "'block.low'", "limits.low"));
  rig.Set(rig->low, 1);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->kd, std::numeric_limits<double>::quiet_NaN()); },
                                     "'block.kd'", "NaN"));
}

TEST(ParameterTest, SeveralAreSetAtOnce) {
  TestRig<Servo> rig;
  rig.context().Set(rig->low, 6, rig->high, 8.0);
  EXPECT_EQ(rig[rig->low], 6);
  EXPECT_EQ(rig[rig->high], 8);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.context().Set(rig->high, 1, rig->low, 2); }, "limits.low"));
  EXPECT_EQ(rig[rig->high], 8) << "nothing is changed";
}

TEST(ParameterTest, IsSavedAndCloned) {
  Loop loop;
  const auto diagram = loop.builder.Build();
  auto context = diagram->CreateContext();
  context->Set(loop.servo->kp, 17);
  EXPECT_EQ(context->Clone()->Eval(loop.servo->kp), 17);
  auto other = diagram->CreateContext();
  other->Restore(context->Save());
  EXPECT_EQ(other->Eval(loop.servo->kp), 17);
}

TEST(ParameterTest, IsListedWithUnitAndDescription) {
  Loop loop;
  const auto diagram = loop.builder.Build();
  const auto parameters = diagram->parameters();
  ASSERT_EQ(parameters.size(), 4u);
  EXPECT_EQ(parameters[0]->path(), "servo.kp");
  EXPECT_EQ(parameters[0]->elements()[0].unit, "N/m");
  EXPECT_EQ(parameters[0]->description(), "stiffness");
  EXPECT_EQ(parameters[0]->initial_numbers(), std::vector<double>{10});
  auto context = diagram->CreateContext();
  context->SetDoubles(*parameters[0], std::vector<double>{4});
  EXPECT_EQ(context->Eval(loop.servo->kp), 4);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { context->SetDoubles(*parameters[0], std::vector<double>{-4}); }, "kp"));
}

TEST(ParameterTest, StructsAreSetAsAWhole) {
  TestRig<Bounded> rig;
  EXPECT_EQ(rig[rig->width], 10);
  rig.Set(rig->limits, {.low = 1, .high = 4});
  EXPECT_EQ(rig[rig->width], 3);
}

/// y = exp(rate) u, the factor computed once for each rate.
class Amplifier final : public LeafSystem<void> {
 public:
  InputPort<double> u{this, {"u"}};
  Parameter<double> rate{this, {"rate"}, 0.0};
  Shared<double> factor{this, "factor", Uses(rate), &Amplifier::CalcFactor};
  OutputPort<double> y{
      this, {"y"}, Sampled{Hz(10)}, Uses(factor, u), [](double factor, double u) { return factor * u; }};
  mutable int count = 0;

 private:
  double CalcFactor(double rate) const {
    ++count;
    return std::exp(rate);
  }
};

TEST(ParameterTest, WhatDependsOnThemAloneIsComputedWhenTheyAreSet) {
  TestRig<Amplifier> rig;
  for (const double u : {1.0, 2.0, 3.0}) EXPECT_EQ(rig.Fix(rig->u, u).Tick()[rig->y], u);
  EXPECT_EQ(rig->count, 1);
  const auto before = rig.context().Save();
  rig.Set(rig->rate, 1);
  for (const double u : {1.0, 2.0, 3.0}) EXPECT_EQ(rig.Fix(rig->u, u).Tick()[rig->y], std::exp(1.0) * u);
  EXPECT_EQ(rig->count, 2);
  EXPECT_EQ(rig.context().Clone()->Eval(rig->factor), std::exp(1.0));
  auto restored = rig.diagram().CreateContext();
  restored->Set(rig->rate, 1);
  EXPECT_EQ(restored->Eval(rig->factor), std::exp(1.0));
  restored->Restore(before);
  EXPECT_EQ(restored->Eval(rig->factor), 1);
}

TEST(ParameterTest, RunsWithoutAllocating) {
  Loop loop;
  Simulator simulator(loop.builder.Build());
  simulator.RunTo(0.1);
  EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.2); }), 0);
}

}  // namespace tenon::parameter_test
