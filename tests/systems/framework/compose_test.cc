// A diagram that ships as a starting point: Replace, Insert, Disconnect, parameters in braces.

#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gtest/gtest.h>

#include <optional>

namespace tenon::compose_test {
namespace {

/// A diagram that ships: a PD controller inside a nested diagram drives a cart.
struct ServoParams {
  double kp = 10;  // N/m
};
class Servo final : public Subdiagram {
 public:
  using Params = ServoParams;
  explicit Servo(const ServoParams& params = {}) : pd(Add<Pd>("pd", {.kp = params.kp})) {
    Connect(x, pd.x);
    Connect(pd.u, u);
  }
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  Pd& pd;
  OutputPort<double> u{this, {"u", "N"}};
};
class Shipped final : public Subdiagram {
 public:
  Shipped() : servo(Add<Servo>("servo")), cart(Add<Cart>("cart")) {
    Connect(cart.state, servo.x);
    Connect(servo.u, cart.force);
  }
  Servo& servo;
  Cart& cart;
};

/// Stands in for Pd: the same ports.
class Bang final : public LeafSystem<double> {
 public:
  explicit Bang(double force) : LeafSystem(force) {}
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  OutputPort<double> u{this, {"u", "N"}, Sampled{Hz(1000)}, Uses(x), [this](const Vec<2>& x) {
                         return x[0] > 0 ? -params : params;
                       }};
};

/// Does not: another type of x, an input of its own, and its output has another name.
class Odd final : public LeafSystem<void> {
 public:
  InputPort<double> x{this, "x", 0.0};
  InputPort<double> goal{this, "goal"};
  OutputPort<double> force{
      this, {"force", "N"}, Uses(x, goal), [](double x, double goal) { return goal - x; }};
};

/// Passes 3 ms later on.
auto& AddDelay(DiagramBuilder& builder) {
  return builder.Add<SampleDelay<double>>("delay", {.samples = 3, .unit = "N"});
}

double ForceAt(const Diagram& diagram, const Cart& cart, double time) {
  Simulator simulator(diagram);
  simulator.context().Set(cart.x, {1, 0});
  simulator.RunTo(time);
  return simulator.context().Eval(cart.force);
}

TEST(ComposeTest, AddTakesParametersInBraces) {
  DiagramBuilder builder;
  EXPECT_EQ(builder.Add<Pd>("pd", {.kp = 3}).params.kp, 3);
  EXPECT_EQ(builder.Add<SampleDelay<Vec<3>>>("delay", {.samples = 3}).params.samples, 3);
  EXPECT_EQ(builder.Add<Servo>("servo", {.kp = 7}).pd.params.kp, 7);
  EXPECT_TRUE(Throws<ParameterError>([&] { builder.Add<Cart>("cart", {.mass = -1}); }, "'cart'", "mass"));
}

TEST(ComposeTest, ReplaceTakesOverConnectionsNameAndPlaceAtAnyDepth) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  const auto& bang = builder.Replace<Bang>(loop.servo.pd, 5.0);
  EXPECT_EQ(bang.path(), "loop.servo.pd");
  EXPECT_EQ(loop.servo.pd.replaced_by(), &bang);
  const auto diagram = builder.Build();
  EXPECT_EQ(ForceAt(*diagram, loop.cart, 0.01), -5);
  EXPECT_EQ(&diagram->FindBlock("loop.servo.pd"), &bang);
}

TEST(ComposeTest, ReplaceByTheSameBlockChangesNoBit) {
  const auto end = [](bool replace) {
    DiagramBuilder builder;
    auto& loop = builder.Add<Shipped>("loop");
    if (replace) builder.Replace<Pd>(loop.servo.pd, {.kp = 10});
    Simulator simulator(builder.Build());
    simulator.context().Set(loop.cart.x, {1, 0});
    simulator.RunTo(2);
    return simulator.context().Save();
  };
  EXPECT_EQ(end(false), end(true));
}

TEST(ComposeTest, ReplaceExchangesWholeNestedDiagrams) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  const auto& servo = builder.Replace<Servo>(loop.servo, {.kp = 20});
  EXPECT_EQ(servo.pd.path(), "loop.servo.pd");
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), -20);
}

TEST(ComposeTest, ReplaceReplacesWhatReplaced) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& odd = builder.Replace<Odd>(loop.servo.pd);
  const auto& bang = builder.Replace<Bang>(odd, 5.0);
  EXPECT_EQ(odd.replaced_by(), &bang);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), -5);
}

TEST(ComposeTest, ReplacedBlocksCostNothing) {
  const auto size = [](bool replace) {
    DiagramBuilder builder;
    auto& loop = builder.Add<Shipped>("loop");
    if (replace) builder.Replace<Pd>(loop.servo.pd);
    return builder.Build()->CreateContext()->Save().size();
  };
  EXPECT_EQ(size(false), size(true));
}

TEST(ComposeTest, PortsThatDifferAreListedInOneError) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& odd = builder.Replace<Odd>(loop.servo.pd);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.servo.pd'", "lacks the output 'u' (double)",
                                 "'loop.servo.u' reads", "input 'goal' (double)",
                                 "'x' (Vec<2>) (its 'x' is a double)", "by hand"));
  // And so they are connected by hand.
  loop.servo.Disconnect(loop.servo.u);
  loop.servo.Connect(odd.force, loop.servo.u);
  builder.Connect(builder.AddFunction({"goal"}, Uses(), [] { return 4.0; }), odd.goal);
  builder.Connect(
      builder.AddFunction({"position"}, Uses(loop.cart.state), [](const Vec<2>& x) { return x[0]; }), odd.x);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), 3);
}

TEST(ComposeTest, PortsOfAReplacedBlockAreRefusedEverywhere) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  builder.Replace<Bang>(loop.servo.pd, 5.0);
  auto& delay = AddDelay(builder);
  const char *replaced = "was replaced", *where = "'loop.servo.pd'";
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(loop.servo.pd.u, delay.u); }, replaced, where));
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.Insert(loop.servo.pd.u, delay.u, delay.y); }, replaced, where));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(loop.servo.pd.x); }, replaced, where));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Bang>(loop.servo.pd, 6.0); }, replaced, where));
  builder.Connect(loop.servo.u, delay.u);
  Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<RunError>([&] { simulator.context().Eval(loop.servo.pd.u); }, replaced, where));
  EXPECT_TRUE(Throws<RunError>([&] { simulator.AddLog(Hz(10), {&loop.servo.pd.u}); }, replaced, where));
}

TEST(ComposeTest, FiguresFindWhatStandsWhereAPortWas) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  const OutputPort<double>& u = loop.servo.pd.u;
  EXPECT_EQ(&Current(u), &u);
  auto& bang = builder.Replace<Bang>(loop.servo.pd, 5.0);
  EXPECT_EQ(&Current(u), &bang.u);
  auto& odd = builder.Replace<Odd>(bang);
  EXPECT_TRUE(Throws<BuildError>([&] { Current(u); }, "'loop.servo.pd.u'", "no 'u' (double)"));
  static_cast<void>(odd);
  auto& servo = builder.Replace<Servo>(loop.servo, {.kp = 20});
  EXPECT_EQ(&Current(u), &servo.pd.u) << "inside of what was exchanged";
}

TEST(ComposeTest, WhatIsReplacedMustBeInTheBuilder) {
  DiagramBuilder builder, other;
  auto& pd = other.Add<Pd>("pd");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Pd>(pd); }, "'pd'", "before Build"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(pd.x); }, "'pd.x'", "before Build"));
}

TEST(ComposeTest, AReplacementThatIsRefusedChangesNothing) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  EXPECT_TRUE(
      Throws<ParameterError>([&] { builder.Replace<Cart>(loop.cart, {.mass = -1}); }, "'loop.cart'", "mass"));
  EXPECT_EQ(loop.cart.replaced_by(), nullptr);
  builder.Build();
}

TEST(ComposeTest, InsertPutsADelayBehindAnOutputForAllThatReadIt) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& delay = AddDelay(builder);
  builder.Insert(loop.servo.u, delay.u, delay.y);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.context().Set(loop.cart.x, {1, 0});
  simulator.RunTo(0.002);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), 0);
  EXPECT_EQ(simulator.context().Eval(loop.servo.u), -10) << "what it was before";
  simulator.RunTo(0.003);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), -10);
}

TEST(ComposeTest, PortsOfNestedDiagramsCountAsReaders) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& delay = AddDelay(builder);
  builder.Insert(loop.servo.pd.u, delay.u, delay.y);  // from the top builder, two levels down
  Simulator simulator(builder.Build());
  simulator.context().Set(loop.cart.x, {1, 0});
  simulator.RunTo(0.001);
  EXPECT_EQ(simulator.context().Eval(loop.servo.u), 0);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), 0);
}

TEST(ComposeTest, InsertRefusesWhatMakesNoSense) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& delay = AddDelay(builder);
  auto& other = builder.Add<SampleDelay<double>>("other");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(delay.y, other.u, other.y); }, "'delay.y'", "'other'"));
  builder.Connect(loop.servo.u, other.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(loop.servo.pd.u, other.u, other.y); }, "'other.u'",
                                 "connected to 'loop.servo.u' already"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(loop.servo.u, delay.u, delay.u); }, "'delay.u'",
                                 "in this order"));
}

TEST(ComposeTest, DisconnectOpensAnInputAgain) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  builder.Disconnect(loop.cart.force);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.cart.force' is not connected"));
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.Disconnect(loop.cart.force); }, "'loop.cart.force'", "no connection"));
  builder.Connect(builder.AddFunction({"constant", "N"}, Uses(), [] { return 3.0; }), loop.cart.force);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), 3);
}

TEST(ComposeTest, WhatIsInsertedIsCheckedAsAnyOther) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& delay = builder.Add<SampleDelay<double>>("delay", {.unit = "m"});
  builder.Insert(loop.servo.u, delay.u, delay.y);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.servo.u' [N]", "'delay.u' [m]"));
}

TEST(ComposeTest, ABuilderThatHasBuiltIsDone) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Shipped>("loop");
  auto& delay = AddDelay(builder);
  builder.Connect(loop.servo.u, delay.u);
  const auto diagram = builder.Build();
  const std::size_t size = diagram->CreateContext()->Save().size();

  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Pd>("pd"); }, "Add('pd')", "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Pd>("pd", {.kp = 3}); }, "Add('pd')", "already built"));
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.AddFunction("f", Uses(builder.time), [](double t) { return t; }); },
                         "AddFunction('f')", "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(loop.servo.u, delay.u); }, "Connect('delay.u')",
                                 "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(loop.servo.u, delay.u, IgnoreUnits{}); },
                                 "Connect('delay.u')", "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Bang>(loop.servo.pd, 5.0); },
                                 "Replace('loop.servo.pd')", "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Pd>(loop.servo.pd, {.kp = 3}); },
                                 "Replace('loop.servo.pd')", "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(loop.servo.u, delay.u, delay.y); }, "Insert('delay.u')",
                                 "already built"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(delay.u); }, "Disconnect('delay.u')",
                                 "already built", "another builder"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "Build()", "already built"));
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.BuildWithOpenInputs(); }, "BuildWithOpenInputs()", "already built"));
  // Nor does what is nested in the diagram change.
  EXPECT_TRUE(Throws<BuildError>([&] { loop.servo.Add<Pd>("pd2"); }, "Add('pd2')", "'loop.servo'"));
  EXPECT_TRUE(Throws<BuildError>([&] { loop.servo.Disconnect(loop.servo.pd.x); },
                                 "Disconnect('loop.servo.pd.x')", "'loop.servo'"));

  EXPECT_EQ(diagram->blocks().size(), 2U);
  EXPECT_EQ(diagram->CreateContext()->Save().size(), size);
}

// A builder may be created at the address of one that is gone.
TEST(ComposeTest, ABuilderKnowsNoBlocksOfTheOneThatWasThereBefore) {
  std::optional<DiagramBuilder> builder;
  builder.emplace();
  auto& loop = builder->Add<Shipped>("loop");
  const auto diagram = builder->Build();
  builder.reset();
  builder.emplace();
  auto& delay = AddDelay(*builder);
  EXPECT_TRUE(Throws<BuildError>([&] { builder->Connect(loop.servo.u, delay.u); }, "'loop.servo.u'",
                                 "another builder"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder->Replace<Bang>(loop.servo.pd, 5.0); }, "'loop.servo.pd'",
                                 "not added to this builder"));
}

}  // namespace
}  // namespace tenon::compose_test
