// Changes to a diagram of a library: Replace, Insert, Disconnect, parameters in braces.

#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::compose_test {

/// A diagram of a library: a PD controller inside a nested diagram drives a cart.
struct ServoParams {
  double kp = 10;  // N/m
};
struct Servo final : Subdiagram {
  using Params = ServoParams;
  explicit Servo(const ServoParams& params = {}) : pd(Add<Pd>("pd", {.kp = params.kp})) {
    Connect(x, pd.x);
    Connect(pd.u, u);
  }
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  Pd& pd;
  OutputPort<double> u{this, {"u", "N"}};
};
struct Shipped final : Subdiagram {
  Shipped() : servo(Add<Servo>("servo")), cart(Add<Cart>("cart")) {
    Connect(cart.state, servo.x);
    Connect(servo.u, cart.force);
  }
  Servo& servo;
  Cart& cart;
};

/// A controller with the ports of Pd.
struct Bang final : LeafSystem<double> {
  explicit Bang(double force) : LeafSystem(force) {}
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  OutputPort<double> u{this, {"u", "N"}, Sampled{Hz(1000)}, Uses(x), [this](const Vec<2>& x) {
                         return x[0] > 0 ? -params : params;
                       }};
};

/// Its ports differ from those of Pd: x has another type, there is another input, the output has another
/// name.
struct Odd final : LeafSystem<void> {
  InputPort<double> x{this, "x", 0.0};
  InputPort<double> goal{this, "goal"};
  OutputPort<double> force{
      this, {"force", "N"}, Uses(x, goal), [](double x, double goal) { return goal - x; }};
};

/// A delay of 3 ms.
auto& AddDelay(DiagramBuilder& builder) {
  return builder.Add<SampleDelay<double>>("delay", {.samples = 3, .unit = "N"});
}

double ForceAt(const Diagram& diagram, const Cart& cart, double time) {
  Simulator simulator(diagram);
  simulator.context().Set(cart.x, {1, 0});
  simulator.RunTo(time);
  return simulator.context().Eval(cart.force);
}

struct ComposeTest : testing::Test {
  DiagramBuilder builder;
  Shipped& loop = builder.Add<Shipped>("loop");
};

TEST(ComposeBuilderTest, AddTakesParametersInBraces) {
  DiagramBuilder builder;
  EXPECT_EQ(builder.Add<Pd>("pd", {.kp = 3}).params.kp, 3);
  EXPECT_EQ(builder.Add<SampleDelay<Vec<3>>>("delay", {.samples = 3}).params.samples, 3);
  EXPECT_EQ(builder.Add<Servo>("servo", {.kp = 7}).pd.params.kp, 7);
  EXPECT_TRUE(Throws<ParameterError>([&] { builder.Add<Cart>("cart", {.mass = -1}); }, "'cart'", "mass"));
}

TEST_F(ComposeTest, ReplaceTakesOverConnectionsNameAndPlaceAtAnyDepth) {
  const auto& bang = builder.Replace<Bang>(loop.servo.pd, 5.0);
  EXPECT_EQ(bang.path(), "loop.servo.pd");
  EXPECT_EQ(loop.servo.pd.replaced_by(), &bang);
  const auto diagram = builder.Build();
  EXPECT_EQ(ForceAt(*diagram, loop.cart, 0.01), -5);
  EXPECT_EQ(&diagram->FindBlock("loop.servo.pd"), &bang);
}

TEST(ComposeBuilderTest, ReplaceByTheSameBlockChangesNoBit) {
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

TEST_F(ComposeTest, ReplaceExchangesWholeNestedDiagrams) {
  const auto& servo = builder.Replace<Servo>(loop.servo, {.kp = 20});
  EXPECT_EQ(servo.pd.path(), "loop.servo.pd");
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), -20);
}

TEST_F(ComposeTest, ReplaceReplacesWhatReplaced) {
  auto& odd = builder.Replace<Odd>(loop.servo.pd);
  const auto& bang = builder.Replace<Bang>(odd, 5.0);
  EXPECT_EQ(odd.replaced_by(), &bang);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), -5);
}

TEST_F(ComposeTest, PortsThatDifferAreListedInOneError) {
  auto& odd = builder.Replace<Odd>(loop.servo.pd);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.servo.pd'", "'u'", "'loop.servo.u'",
                                 "'goal'", "'x'"));
  // The user connects them.
  loop.servo.Disconnect(loop.servo.u);
  loop.servo.Connect(odd.force, loop.servo.u);
  builder.Connect(builder.AddFunction({"goal"}, Uses(), [] { return 4.0; }), odd.goal);
  builder.Connect(
      builder.AddFunction({"position"}, Uses(loop.cart.state), [](const Vec<2>& x) { return x[0]; }), odd.x);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), 3);
}

TEST_F(ComposeTest, PortsOfAReplacedBlockMeanThoseOfTheBlockInItsPlace) {
  const OutputPort<double>& u = loop.servo.pd.u;
  auto& first = builder.Replace<Bang>(loop.servo.pd, 4.0);
  auto& bang = builder.Replace<Bang>(loop.servo.pd, 5.0);  // replaces the first one
  EXPECT_EQ(first.replaced_by(), &bang);
  EXPECT_EQ(&Current(u), &bang.u);
  EXPECT_EQ(CurrentBlock(loop.servo.pd), &bang);
  auto& delay = AddDelay(builder);
  builder.Insert(u, delay.u, delay.y);
  auto& twice = builder.AddFunction({"twice", "N"}, Uses(u), [](double force) { return 2 * force; });
  builder.Disconnect(loop.servo.pd.x);
  builder.Connect(loop.servo.x, loop.servo.pd.x);
  Simulator simulator(builder.Build());
  simulator.context().Set(loop.cart.x, {1, 0});
  const auto log = simulator.AddLog(Hz(1000), {&u});
  simulator.RunTo(0.002);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), 0) << "behind the delay";
  EXPECT_EQ(simulator.context().Eval(u), -5);
  EXPECT_EQ(simulator.context().EvalDoubles(first.u), std::vector<double>{-5});
  EXPECT_EQ(simulator.context().Eval(twice), -10);
  EXPECT_EQ(log->column("loop.servo.pd.u").back(), -5);
}

TEST_F(ComposeTest, APortThatTheBlockInThePlaceLacksIsNamedWithTheRemedy) {
  const OutputPort<double>& u = loop.servo.pd.u;
  builder.Replace<Odd>(loop.servo.pd);
  auto& delay = AddDelay(builder);
  const auto refused = [&](auto call) {
    return Throws<BuildError>(call, "'loop.servo.pd.u'", "'u'", "double", "add it");
  };
  EXPECT_TRUE(refused([&] { builder.Connect(u, delay.u); }));
  EXPECT_TRUE(refused([&] { builder.Insert(u, delay.u, delay.y); }));
  EXPECT_TRUE(refused([&] { builder.AddFunction("f", Uses(u), [](double x) { return x; }); }));
  EXPECT_TRUE(refused([&] { Current(u); }));
  EXPECT_EQ(FindCurrent(u), nullptr);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(loop.servo.pd.x); }, "'loop.servo.pd.x'"));
  auto& servo = builder.Replace<Servo>(loop.servo, {.kp = 20});
  EXPECT_EQ(&Current(u), &servo.pd.u) << "inside of what was exchanged";
  builder.Replace<Odd>(loop.servo);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Bang>(loop.servo.pd, 5.0); }, "'loop.servo.pd'"));
}

TEST_F(ComposeTest, ParametersAreThoseOfTheBlockInThePlace) {
  const Pd& pd = loop.servo.pd;
  EXPECT_EQ(&CurrentAs(pd), &pd);
  const Pd& stiff = builder.Replace<Pd>(pd, {.kp = 20});
  EXPECT_EQ(CurrentAs(pd).params.kp, 20);
  const Bang& bang = builder.Replace<Bang>(pd, 5.0);
  EXPECT_EQ(&CurrentAs(pd), &stiff) << "a Bang has no such parameters";
  builder.Replace<Bang>(bang, 6.0);
  EXPECT_EQ(CurrentAs<LeafSystem<double>>(bang).params, 6);
  builder.Replace<Servo>(loop.servo, {.kp = 30});
  EXPECT_EQ(CurrentAs(pd).params.kp, 30) << "inside of what was exchanged";
}

TEST_F(ComposeTest, InsertExceptsReadersAndGoesInFrontOfOneInput) {
  auto& seen = builder.Add<SampleDelay<double>>("seen", {.samples = 1, .unit = "N"});
  builder.Connect(loop.servo.u, seen.u);
  auto& delay = AddDelay(builder);
  builder.Insert(loop.servo.u, delay.u, delay.y, {&seen.u});
  auto& last = builder.Add<SampleDelay<double>>("last", {.samples = 1, .unit = "N"});
  builder.InsertBefore(loop.cart.force, last.u, last.y);
  EXPECT_EQ(seen.u.driver(), &loop.servo.u);
  EXPECT_EQ(last.u.driver(), &delay.y);
  EXPECT_EQ(loop.cart.force.driver(), &last.y);
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.Insert(last.y, last.u, last.y, {&loop.cart.force}); }, "'last"));
  // An input without a connection leaves the inserted block without one.
  auto& alone = builder.Add<SampleDelay<double>>("alone", {.samples = 1, .unit = "N"});
  auto& before = builder.Add<SampleDelay<double>>("before", {.samples = 1, .unit = "N"});
  builder.InsertBefore(alone.u, before.u, before.y);
  EXPECT_EQ(before.u.driver(), nullptr);
  EXPECT_EQ(alone.u.driver(), &before.y);
}

TEST(ComposeBuilderTest, WhatIsReplacedMustBeInTheBuilder) {
  DiagramBuilder builder, other;
  auto& pd = other.Add<Pd>("pd");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Replace<Pd>(pd); }, "'pd'"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(pd.x); }, "'pd.x'"));
}

TEST_F(ComposeTest, AReplacementThatIsRefusedChangesNothing) {
  EXPECT_TRUE(
      Throws<ParameterError>([&] { builder.Replace<Cart>(loop.cart, {.mass = -1}); }, "'loop.cart'", "mass"));
  EXPECT_EQ(loop.cart.replaced_by(), nullptr);
  builder.Build();
}

TEST_F(ComposeTest, InsertPutsADelayBehindAnOutputForAllThatReadIt) {
  auto& delay = AddDelay(builder);
  builder.Insert(loop.servo.u, delay.u, delay.y);
  Simulator simulator(builder.Build());
  simulator.context().Set(loop.cart.x, {1, 0});
  simulator.RunTo(0.002);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), 0);
  EXPECT_EQ(simulator.context().Eval(loop.servo.u), -10) << "what it was before";
  simulator.RunTo(0.003);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), -10);
}

TEST_F(ComposeTest, PortsOfNestedDiagramsCountAsReaders) {
  auto& delay = AddDelay(builder);
  builder.Insert(loop.servo.pd.u, delay.u, delay.y);  // from the top builder, two levels down
  Simulator simulator(builder.Build());
  simulator.context().Set(loop.cart.x, {1, 0});
  simulator.RunTo(0.001);
  EXPECT_EQ(simulator.context().Eval(loop.servo.u), 0);
  EXPECT_EQ(simulator.context().Eval(loop.cart.force), 0);
}

TEST_F(ComposeTest, InsertRefusesWhatMakesNoSense) {
  auto& delay = AddDelay(builder);
  auto& other = builder.Add<SampleDelay<double>>("other");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(delay.y, other.u, other.y); }, "'delay.y'", "other"));
  builder.Connect(loop.servo.u, other.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(loop.servo.pd.u, other.u, other.y); }, "'other.u'",
                                 "'loop.servo.u'"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Insert(loop.servo.u, delay.u, delay.u); }, "'delay.u'"));
}

TEST_F(ComposeTest, DisconnectOpensAnInputAgain) {
  builder.Disconnect(loop.cart.force);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.cart.force'"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Disconnect(loop.cart.force); }, "'loop.cart.force'"));
  builder.Connect(builder.AddFunction({"constant", "N"}, Uses(), [] { return 3.0; }), loop.cart.force);
  EXPECT_EQ(ForceAt(*builder.Build(), loop.cart, 0), 3);
}

TEST_F(ComposeTest, WhatIsInsertedIsCheckedAsAnyOther) {
  auto& delay = builder.Add<SampleDelay<double>>("delay", {.unit = "m"});
  builder.Insert(loop.servo.u, delay.u, delay.y);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'loop.servo.u'", "'delay.u'"));
}

TEST_F(ComposeTest, ABuilderThatHasBuiltIsDone) {
  auto& delay = AddDelay(builder);
  builder.Connect(loop.servo.u, delay.u);
  const auto diagram = builder.Build();
  const std::size_t size = diagram->CreateContext()->Save().size();

  const std::pair<const char*, std::function<void()>> calls[] = {
      {"Add('pd')", [&] { builder.Add<Pd>("pd"); }},
      {"Add('pd')", [&] { builder.Add<Pd>("pd", {.kp = 3}); }},
      {"AddFunction('f')", [&] { builder.AddFunction("f", Uses(), [] { return 1.0; }); }},
      {"Connect('delay.u')", [&] { builder.Connect(loop.servo.u, delay.u); }},
      {"Connect('delay.u')", [&] { builder.Connect(loop.servo.u, delay.u, IgnoreUnits{}); }},
      {"Replace('loop.servo.pd')", [&] { builder.Replace<Bang>(loop.servo.pd, 5.0); }},
      {"Replace('loop.servo.pd')", [&] { builder.Replace<Pd>(loop.servo.pd, {.kp = 3}); }},
      {"Insert('delay.u')", [&] { builder.Insert(loop.servo.u, delay.u, delay.y); }},
      {"Disconnect('delay.u')", [&] { builder.Disconnect(delay.u); }},
      {"Build()", [&] { builder.Build(); }},
      {"BuildWithOpenInputs()", [&] { builder.BuildWithOpenInputs(); }},
      // Nor does a nested diagram change.
      {"Add('pd2')", [&] { loop.servo.Add<Pd>("pd2"); }},
      {"Disconnect('loop.servo.pd.x')", [&] { loop.servo.Disconnect(loop.servo.pd.x); }}};
  for (const auto& [name, call] : calls) EXPECT_TRUE(Throws<BuildError>(call, name));
  EXPECT_EQ(diagram->blocks().size(), 2U);
  EXPECT_EQ(diagram->CreateContext()->Save().size(), size);
}

// A builder may have the address of an earlier one that was destroyed.
TEST(ComposeBuilderTest, ABuilderKnowsNoBlocksOfTheOneThatWasThereBefore) {
  std::optional<DiagramBuilder> builder;
  builder.emplace();
  auto& loop = builder->Add<Shipped>("loop");
  const auto diagram = builder->Build();
  builder.reset();
  builder.emplace();
  auto& delay = AddDelay(*builder);
  EXPECT_TRUE(Throws<BuildError>([&] { builder->Connect(loop.servo.u, delay.u); }, "'loop.servo.u'"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder->Replace<Bang>(loop.servo.pd, 5.0); }, "'loop.servo.pd'"));
}

}  // namespace tenon::compose_test
