#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::diagram_builder_test {

using ::testing::ElementsAre, ::testing::ThrowsMessage;

const auto kSame = [](double u) { return u; };

/// A nested diagram with one Map, whose ports may be left unconnected.
struct BoxParams {
  bool connect_input = true;
  bool connect_output = true;
};
struct Box final : Subdiagram {
  explicit Box(BoxParams params = {}, std::function<double(double)> f = kSame) : map(Add<Map>("map", f)) {
    if (params.connect_input) Connect(in, map.u);
    if (params.connect_output) Connect(map.y, out);
  }
  InputPort<double> in{this, "in"};
  OutputPort<double> out{this, "out"};
  Map& map;
};

/// A nested diagram with a Box.
struct Chest final : Subdiagram {
  Chest() : box(Add<Box>("box")) {
    Connect(in, box.in);
    Connect(box.out, out);
  }
  InputPort<double> in{this, "in"};
  OutputPort<double> out{this, "out"};
  Box& box;
};

// ---- Inputs ----

using DiagramBuilderTest = DiagramTest;

TEST_F(DiagramBuilderTest, UnconnectedInputOfNestedDiagramNamesBothEnds) {
  builder.Add<Chest>("chest");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'chest.in'", "'chest.box.map.u'"));
}

TEST_F(DiagramBuilderTest, InputOfNestedDiagramThatNobodyReadsMustBeConnectedToo) {
  struct Deaf final : Subdiagram {
    InputPort<double> in{this, "in"};
  };
  DiagramBuilder closed;
  closed.Add<Deaf>("deaf");
  EXPECT_TRUE(Throws<BuildError>([&] { closed.Build(); }, "'deaf.in'"));
  DiagramBuilder open;
  auto& deaf = open.Add<Deaf>("deaf");
  const auto context = open.BuildWithOpenInputs()->CreateContext();
  context->Set(deaf.in, 3.0);
  EXPECT_EQ(context->Eval(deaf.in), 3);
  EXPECT_EQ(context->time(), 0);
}

TEST_F(DiagramBuilderTest, OpenInputsAreListedOnce) {
  auto& chest = builder.Add<Chest>("chest");
  auto& cart = builder.Add<Cart>("cart");
  const auto diagram = builder.BuildWithOpenInputs();
  EXPECT_THAT(diagram->open_inputs(), testing::UnorderedElementsAre(&chest.in, &cart.force));
  const auto context = diagram->CreateContext();
  context->Set(chest.box.map.u, 5.0);  // any port on the way names the same value
  EXPECT_EQ(context->Eval(chest.in), 5);
  EXPECT_EQ(context->Eval(chest.out), 5);
}

TEST_F(DiagramBuilderTest, OptionalInputsReadAsTheirDefault) {
  struct Optional final : LeafSystem<void> {
    InputPort<double> u{this, "u", 7.0};
    OutputPort<double> y{this, "y", Uses(u), kSame};
  };
  struct Wrapper final : Subdiagram {
    Wrapper() : a(Add<Optional>("a")), b(Add<Optional>("b")) { Connect(in, a.u), Connect(in, b.u); }
    InputPort<double> in{this, "in", 9.0};
    Optional &a, &b;
  };
  auto& alone = builder.Add<Optional>("alone");
  auto& connected = builder.Add<Optional>("connected");
  auto& wrapper = builder.Add<Wrapper>("wrapper");
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), connected.u);
  const auto context = builder.Build()->CreateContext();
  EXPECT_EQ(context->Eval(alone.y), 7);
  EXPECT_EQ(context->Eval(connected.y), 1);
  EXPECT_EQ(context->Eval(wrapper.a.y), 9);
  EXPECT_EQ(context->Eval(wrapper.b.y), 9);
  context->Set(wrapper.in, 10.0);
  EXPECT_EQ(context->Eval(wrapper.b.y), 10);
}

// ---- Connections ----

TEST_F(DiagramBuilderTest, PortConnectedTwiceNamesBothSources) {
  auto& a = builder.Add<Map>("a", kSame);
  auto& b = builder.Add<Map>("b", kSame);
  auto& c = builder.Add<Map>("c", kSame);
  builder.Connect(a.y, c.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(b.y, c.u); }, "'c.u'", "'a.y'", "'b.y'"));
}

TEST_F(DiagramBuilderTest, PortsOfAnotherBuilderAreRefused) {
  DiagramBuilder other;
  auto& here = builder.Add<Map>("here", kSame);
  auto& there = other.Add<Map>("there", kSame);
  const auto refused = [](const char* port, const char* role) {
    return ThrowsMessage<BuildError>(HasSubstrs(port, role, "another builder"));
  };
  EXPECT_THAT([&] { builder.Connect(there.y, here.u); }, refused("'there.y'", "source"));
  EXPECT_THAT([&] { builder.Connect(here.y, there.u); }, refused("'there.u'", "target"));
}

TEST_F(DiagramBuilderTest, PortsInsideANestedDiagramAreRefusedFromAnother) {
  struct Outer final : Subdiagram {
    Outer() {
      auto& box = Add<Box>("box", BoxParams{.connect_input = false});
      Connect(Add<Map>("map", kSame).y, box.map.u);
    }
  };
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Outer>("outer"); }, "'box.map.u'", "nested"));
}

TEST_F(DiagramBuilderTest, TheBuilderReachesPortsAtAnyDepth) {
  auto& box = builder.Add<Box>("box", BoxParams{.connect_input = false});
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), box.map.u);
  builder.Connect(builder.AddFunction("other", Uses(), [] { return 2.0; }), box.in);
  auto& map = builder.Add<Map>("map", kSame);
  builder.Connect(box.map.y, map.u);
  EXPECT_EQ(builder.Build()->CreateContext()->Eval(map.y), box.map.params(1.0));
}

TEST_F(DiagramBuilderTest, WrongDirectionIsRefused) {
  auto& a = builder.Add<Map>("a", kSame);
  auto& b = builder.Add<Map>("b", kSame);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(a.u, b.u); }, "'a.u'"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Connect(a.y, b.y); }, "'b.y'"));
}

TEST_F(DiagramBuilderTest, OutputOfNestedDiagramNeedsSomethingInside) {
  for (const bool read : {true, false}) {
    DiagramBuilder fresh;
    auto& box = fresh.Add<Box>("box", BoxParams{.connect_output = false});
    fresh.Connect(fresh.AddFunction("one", Uses(), [] { return 1.0; }), box.in);
    if (read) fresh.Connect(box.out, fresh.Add<Map>("reader", kSame).u);
    EXPECT_TRUE(Throws<BuildError>([&] { fresh.Build(); }, "'box.out'"));
  }
}

// ---- Names and parameters ----

TEST_F(DiagramBuilderTest, TwoBlocksOfOneNameAreRefused) {
  builder.Add<Map>("pd", kSame);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Map>("pd", kSame); }, "'pd'"));
  struct Twins final : Subdiagram {
    Twins() { Add<Map>("twin", kSame), Add<Map>("twin", kSame); }
  };
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Twins>("twins"); }, "'twins'", "'twin'"));
}

TEST_F(DiagramBuilderTest, BadNamesAreRefused) {
  for (const char* name : {"", "a.b", "a b", "a,b", "a\tb"})
    EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Map>(name, kSame); }, "'" + std::string(name) + "'"));
}

TEST_F(DiagramBuilderTest, RefusedParametersNameTheBlock) {
  EXPECT_TRUE(Throws<ParameterError>([&] { builder.Add<Cart>("cart", {.mass = -1}); }, "'cart'", "mass"));
  struct Train final : Subdiagram {
    Train() { Add<Cart>("first", CartParams{.mass = 0}); }
  };
  EXPECT_TRUE(Throws<ParameterError>([&] { builder.Add<Train>("train"); }, "'train'", "'first'", "mass"));
  EXPECT_TRUE(builder.blocks().empty());
}

// ---- Algebraic loops ----

TEST_F(DiagramBuilderTest, AlgebraicLoopNamesEveryHop) {
  auto& before = builder.Add<Map>("before", kSame);  // leads into the loop, but is not of it
  auto& a = builder.Add<Map>("a", kSame);
  auto& box = builder.Add<Box>("box");
  auto& c = builder.Add<Map>("c", kSame);
  builder.Connect(a.y, before.u);
  builder.Connect(c.y, a.u);
  builder.Connect(a.y, box.in);
  builder.Connect(box.out, c.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'a.y'", "'c.y'", "'box.map.y'"));
}

TEST_F(DiagramBuilderTest, LoopOfSampledBlocksIsOneAtDifferentRatesToo) {
  auto& fast = builder.Add<SampledMap>("fast", {kSame, {Hz(100)}});
  auto& slow = builder.Add<SampledMap>("slow", {kSame, {Hz(10)}});
  builder.Connect(fast.y, slow.u);
  builder.Connect(slow.y, fast.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'fast.y'", "'slow.y'", "UnitDelay"));
}

TEST_F(DiagramBuilderTest, LoopThroughASharedValueIsFound) {
  struct Block final : LeafSystem<void> {
    InputPort<double> u{this, "u"};
    Shared<double> twice{this, "twice", Uses(u), [](double u) { return 2 * u; }};
    OutputPort<double> y{this, "y", Uses(twice), kSame};
  };
  auto& block = builder.Add<Block>("block");
  builder.Connect(block.y, block.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'block.y'"));
}

struct Filter final : LeafSystem<void> {
  InputPort<double> u{this, "u"};
  ContinuousState<double> x{this, "x", 3.0};
  OutputPort<double> slow{this, "slow", Uses(x), kSame};
  OutputPort<double> error{this, "error", Uses(x, u), [](double x, double u) { return u - x; }};
  TimeDerivative<double> dx{x, Uses(x, u), [](double x, double u) { return u - x; }};
};

TEST_F(DiagramBuilderTest, OutputsThatShowOnlyStateCloseNoLoop) {
  // `slow` shows the state and `error` has feedthrough. The loop leads through `slow`.
  struct Delay final : LeafSystem<void> {
    InputPort<double> u{this, "u"};
    DiscreteState<double> d{this, "d", 1.0};
    OutputPort<double> y{this, d};
    Update<double> next{d, Sampled{Hz(10)}, Uses(u), kSame};
  };
  auto& filter = builder.Add<Filter>("filter");
  auto& delay = builder.Add<Delay>("delay");
  auto& negate = builder.Add<Map>("negate", [](double u) { return -u; });
  builder.Connect(filter.slow, negate.u);
  builder.Connect(negate.y, filter.u);
  builder.Connect(delay.y, delay.u);
  const auto context = builder.Build()->CreateContext();
  EXPECT_EQ(context->Eval(filter.error), -6);
  EXPECT_EQ(context->Eval(delay.y), 1);
}

// ---- Declarations ----

TEST_F(DiagramBuilderTest, UseOfAnotherBlocksPortIsRefused) {
  struct Thief final : LeafSystem<const Map*> {
    explicit Thief(const Map* victim) : LeafSystem(victim) {}
    OutputPort<double> y{this, "y", Uses(params->y), kSame};
  };
  auto& map = builder.Add<Map>("map", kSame);
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), map.u);
  builder.Add<Thief>("thief", &map);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'thief.y'", "'map.y'"));
}

template <class Block>
auto BuildWith() {
  return [] {
    DiagramBuilder builder;
    builder.Add<Block>("block");
    builder.Build();
  };
}

struct Two final : LeafSystem<void> {
  ContinuousState<double> x{this, "x"};
  TimeDerivative<double> a{x, Uses(), [] { return 1.0; }};
  TimeDerivative<double> b{x, Uses(), [] { return 2.0; }};
};

TEST_F(DiagramBuilderTest, EveryContinuousStateHasOneDerivative) {
  struct None final : LeafSystem<void> {
    ContinuousState<double> x{this, "x"};
  };
  EXPECT_TRUE(Throws<BuildError>(BuildWith<Two>(), "'block.x'"));
  EXPECT_TRUE(Throws<BuildError>(BuildWith<None>(), "'block.x'"));
}

struct HalfDescribed {
  double a = 0, b = 0;
  static FieldList Fields() { return {{"a", &HalfDescribed::a}, Undescribed(&HalfDescribed::b)}; }
};

TEST_F(DiagramBuilderTest, ContinuousStateListsAllItsMembers) {
  struct Block final : LeafSystem<void> {
    ContinuousState<HalfDescribed> x{this, "x"};
    TimeDerivative<HalfDescribed> dx{x, Uses(x), [](const HalfDescribed& x) { return x; }};
  };
  EXPECT_TRUE(Throws<BuildError>(BuildWith<Block>(), "'block.x'"));
}

TEST_F(DiagramBuilderTest, OffsetNeedsAnInitialValue) {
  struct Block final : LeafSystem<void> {
    OutputPort<double> y{this, "y", Sampled{Hz(10), 0.05}, Uses(time), kSame};
  };
  EXPECT_TRUE(Throws<BuildError>(BuildWith<Block>(), "'block.y'", "t = 0.05 s"));
}

struct TwoRates final : LeafSystem<void> {
  DiscreteState<int> n{this, "n"};
  Update<int> a{n, Sampled{Hz(10)}, Uses(), [] { return 1; }};
  Update<int> b{n, Sampled{Hz(20)}, Uses(), [] { return 2; }};
};

struct TwoStarts final : LeafSystem<void> {
  DiscreteState<int> n{this, "n"};
  Update<int> a{n, AtStart{}, Uses(), [] { return 1; }};
  Update<int> b{n, AtStart{}, Uses(), [] { return 2; }};
};

struct Different final : LeafSystem<void> {
  DiscreteState<int> n{this, "n"};
  Update<int> a{n, AtStart{}, Uses(), [] { return 1; }};
  Update<int> b{n, Sampled{Hz(20)}, Uses(), [] { return 2; }};
};

TEST_F(DiagramBuilderTest, TwoUpdatesOfOneStateAndTriggerAreRefused) {
  EXPECT_TRUE(Throws<BuildError>(BuildWith<TwoRates>(), "'block.n'", "merge"));
  EXPECT_TRUE(Throws<BuildError>(BuildWith<TwoStarts>(), "'block.n'"));
  EXPECT_NO_THROW(BuildWith<Different>()());
}

struct Block final : LeafSystem<void> {
  Scratch<double> warm{this, "warm"};
  OutputPort<double> y{this, "y", Uses(warm), [](double& w) { return w; }};
  OutputPort<double> z{this, "z", Uses(warm), [](double& w) { return w; }};
};

TEST_F(DiagramBuilderTest, ScratchBelongsToOneCalculation) {
  EXPECT_TRUE(Throws<BuildError>(BuildWith<Block>(), "'block.warm'", "'y'", "'z'"));
}

TEST_F(DiagramBuilderTest, RandomNumbersAreForSampledCalculations) {
  struct Block final : LeafSystem<void> {
    Random random{this, "random"};
    OutputPort<double> y{this, "y", Uses(random), [](RandomStream& r) { return r.Normal(); }};
  };
  EXPECT_TRUE(Throws<BuildError>(BuildWith<Block>(), "'block.y'", "'random'"));
}

TEST_F(DiagramBuilderTest, RatesMayMeetSeldom) {
  auto& a = builder.Add<Counter>("a", Sampled{Rate::FromPeriod(1, 99991)});
  auto& b = builder.Add<Counter>("b", Sampled{Rate::FromPeriod(100003, 1000000)});
  auto& c = builder.Add<Counter>("c", Sampled{Rate::FromPeriod(1, 1000)});
  Simulator simulator(builder.Build());
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(a.n), 99992);
  EXPECT_EQ(simulator.context().Eval(b.n), 10);
  EXPECT_EQ(simulator.context().Eval(c.n), 1001);
}

TEST_F(DiagramBuilderTest, AHundredRatesAreNotTooMany) {
  std::vector<Counter*> counters;
  for (int i = 1; i <= 100; ++i)
    counters.push_back(
        &builder.Add<Counter>("every_" + std::to_string(i), Sampled{Rate::FromPeriod(i, 1000)}));
  Simulator simulator(builder.Build());
  simulator.RunTo(1);
  for (int i = 1; i <= 100; ++i) EXPECT_EQ(simulator.context().Eval(counters[i - 1]->n), 1000 / i + 1);
}

// ---- Functions as blocks ----

TEST_F(DiagramBuilderTest, FunctionsOfSeveralPortsAndTime) {
  auto& two = builder.AddFunction("two", Uses(), [] { return 2.0; });
  auto& vector = builder.AddFunction({"vector", "N", "left, right"}, Uses(two, builder.time),
                                     [](double a, double t) { return Vec<2>(a, t); });
  auto& sum = builder.AddFunction("sum", Uses(two, vector, two),
                                  [](double a, const Vec<2>& v, double b) { return a + v.sum() + b; });
  auto& held = builder.AddFunction("held", Sampled{Hz(10)}, Uses(sum), kSame);
  EXPECT_EQ(vector.path(), "vector.output");
  EXPECT_EQ(vector.elements()[1].name, "right");
  EXPECT_EQ(vector.elements()[1].unit, "N");
  Simulator simulator(builder.Build());
  simulator.RunTo(0.25);
  EXPECT_EQ(simulator.context().Eval(sum), 2 + 2 + 0.25 + 2);
  EXPECT_EQ(simulator.context().Eval(held), 2 + 2 + 0.2 + 2);
}

// ---- Ports known at run time only ----

TEST_F(DiagramBuilderTest, UndeclaredReadAtRunTimeIsNamed) {
  struct Chooser final : LeafSystem<bool> {
    explicit Chooser(bool declare) : LeafSystem(declare) {}
    InputPort<double> a{this, "a", 1.0};
    InputPort<double> b{this, "b", 2.0};
    OutputPort<double> y{
        this, "y",
        UsesAtRunTime(params ? std::vector<const Source*>{&a, &b} : std::vector<const Source*>{&a}),
        &Chooser::Calc};

   private:
    double Calc(const Reads& reads) const { return reads[a] + reads[b]; }
  };
  auto& good = builder.Add<Chooser>("good", true);
  auto& bad = builder.Add<Chooser>("bad", false);
  const auto context = builder.Build()->CreateContext();
  EXPECT_EQ(context->Eval(good.y), 3);
  EXPECT_TRUE(Throws<RunError>([&] { context->Eval(bad.y); }, "'bad.y'", "'bad.b'", "UsesAtRunTime"));
}

// ---- Looking things up ----

TEST_F(DiagramBuilderTest, FindGivesTheNearestName) {
  PdLoop loop;
  const auto diagram = loop.builder.Build();
  EXPECT_EQ(&diagram->Find("pd.u"), &loop.pd.u);
  EXPECT_EQ(&diagram->FindBlock("cart"), &loop.cart);
  EXPECT_TRUE(Throws<Error>([&] { diagram->Find("pd.v"); }, "'pd.v'"));
  EXPECT_TRUE(Throws<Error>([&] { diagram->FindBlock("card"); }, "'cart'"));
  EXPECT_THAT(diagram->ContinuousStateNames(), ElementsAre("cart.x.position", "cart.x.velocity"));
}

}  // namespace tenon::diagram_builder_test
