#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon::diagram_builder_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const auto kSame = [](double u) { return u; };

/// Holds one Map; its ports may be connected inside or not.
struct BoxParams {
  bool connect_input = true;
  bool connect_output = true;
};
class Box final : public Subdiagram {
 public:
  explicit Box(BoxParams params = {}, std::function<double(double)> f = kSame) : map(Add<Map>("map", f)) {
    if (params.connect_input) Connect(in, map.u);
    if (params.connect_output) Connect(map.y, out);
  }
  InputPort<double> in{this, "in"};
  OutputPort<double> out{this, "out"};
  Map& map;
};

/// A Box in a Box.
class Chest final : public Subdiagram {
 public:
  Chest() : box(Add<Box>("box")) {
    Connect(in, box.in);
    Connect(box.out, out);
  }
  InputPort<double> in{this, "in"};
  OutputPort<double> out{this, "out"};
  Box& box;
};

// ---- Inputs ----

TEST(DiagramBuilderTest, UnconnectedInputIsNamed) {
  DiagramBuilder builder;
  builder.Add<Cart>("cart");
  EXPECT_THAT([&] { builder.Build(); },
              ThrowsMessage<BuildError>(AllOf(HasSubstr("input 'cart.force' is not connected"),
                                              HasSubstr("connect an output to it"))));
}

TEST(DiagramBuilderTest, UnconnectedInputOfNestedDiagramNamesBothEnds) {
  DiagramBuilder builder;
  builder.Add<Chest>("chest");
  EXPECT_THAT([&] { builder.Build(); },
              ThrowsMessage<BuildError>(
                  AllOf(HasSubstr("input 'chest.in' is not connected"), HasSubstr("'chest.box.map.u'"))));
}

TEST(DiagramBuilderTest, UnconnectedInnerInputIsNamed) {
  DiagramBuilder builder;
  auto& box = builder.Add<Box>("box", BoxParams{.connect_input = false});
  auto& one = builder.AddFunction("one", Uses(), [] { return 1.0; });
  builder.Connect(one, box.in);
  EXPECT_THAT([&] { builder.Build(); },
              ThrowsMessage<BuildError>(HasSubstr("input 'box.map.u' is not connected")));
}

TEST(DiagramBuilderTest, InputOfNestedDiagramThatNobodyReadsMustBeConnectedToo) {
  class Deaf final : public Subdiagram {
   public:
    InputPort<double> in{this, "in"};
  };
  DiagramBuilder closed;
  closed.Add<Deaf>("deaf");
  EXPECT_THAT([&] { closed.Build(); },
              ThrowsMessage<BuildError>(HasSubstr("input 'deaf.in' is not connected")));
  DiagramBuilder open;
  auto& deaf = open.Add<Deaf>("deaf");
  const auto diagram = open.BuildWithOpenInputs();
  const auto context = diagram->CreateContext();
  context->Set(deaf.in, 3.0);
  EXPECT_EQ(context->Eval(deaf.in), 3);
  EXPECT_EQ(context->time(), 0);
}

TEST(DiagramBuilderTest, OpenInputsAreListedOnce) {
  DiagramBuilder builder;
  auto& chest = builder.Add<Chest>("chest");
  auto& cart = builder.Add<Cart>("cart");
  const auto diagram = builder.BuildWithOpenInputs();
  EXPECT_THAT(diagram->open_inputs(), testing::UnorderedElementsAre(&chest.in, &cart.force));
  const auto context = diagram->CreateContext();
  context->Set(chest.box.map.u, 5.0);  // any port on the way names the same value
  EXPECT_EQ(context->Eval(chest.in), 5);
  EXPECT_EQ(context->Eval(chest.out), 5);
}

TEST(DiagramBuilderTest, OptionalInputsReadAsTheirDefault) {
  class Optional final : public LeafSystem<void> {
   public:
    InputPort<double> u{this, "u", 7.0};
    OutputPort<double> y{this, "y", Uses(u), kSame};
  };
  class Wrapper final : public Subdiagram {
   public:
    Wrapper() : a(Add<Optional>("a")), b(Add<Optional>("b")) { Connect(in, a.u), Connect(in, b.u); }
    InputPort<double> in{this, "in", 9.0};
    Optional &a, &b;
  };
  DiagramBuilder builder;
  auto& alone = builder.Add<Optional>("alone");
  auto& connected = builder.Add<Optional>("connected");
  auto& wrapper = builder.Add<Wrapper>("wrapper");
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), connected.u);
  const auto diagram = builder.Build();
  const auto context = diagram->CreateContext();
  EXPECT_EQ(context->Eval(alone.y), 7);
  EXPECT_EQ(context->Eval(connected.y), 1);
  EXPECT_EQ(context->Eval(wrapper.a.y), 9);
  EXPECT_EQ(context->Eval(wrapper.b.y), 9);
  context->Set(wrapper.in, 10.0);
  EXPECT_EQ(context->Eval(wrapper.b.y), 10);
}

// ---- Connections ----

TEST(DiagramBuilderTest, PortConnectedTwiceNamesBothSources) {
  DiagramBuilder builder;
  auto& a = builder.Add<Map>("a", kSame);
  auto& b = builder.Add<Map>("b", kSame);
  auto& c = builder.Add<Map>("c", kSame);
  builder.Connect(a.y, c.u);
  EXPECT_THAT([&] { builder.Connect(b.y, c.u); },
              ThrowsMessage<BuildError>(AllOf(HasSubstr("port 'c.u' is connected twice"), HasSubstr("'a.y'"),
                                              HasSubstr("'b.y'"), HasSubstr("remove one"))));
}

TEST(DiagramBuilderTest, PortsOfAnotherBuilderAreRefused) {
  DiagramBuilder builder, other;
  auto& here = builder.Add<Map>("here", kSame);
  auto& there = other.Add<Map>("there", kSame);
  const auto refused = [](const char* port, const char* role) {
    return ThrowsMessage<BuildError>(
        AllOf(HasSubstr(port), HasSubstr(role), HasSubstr("belongs to a block of another builder")));
  };
  EXPECT_THAT([&] { builder.Connect(there.y, here.u); }, refused("'there.y'", "source"));
  EXPECT_THAT([&] { builder.Connect(here.y, there.u); }, refused("'there.u'", "target"));
}

TEST(DiagramBuilderTest, PortsInsideANestedDiagramAreRefusedFromAnother) {
  class Outer final : public Subdiagram {
   public:
    Outer() {
      auto& box = Add<Box>("box", BoxParams{.connect_input = false});
      Connect(Add<Map>("map", kSame).y, box.map.u);
    }
  };
  DiagramBuilder builder;
  EXPECT_THAT(
      [&] { builder.Add<Outer>("outer"); },
      ThrowsMessage<BuildError>(AllOf(HasSubstr("'box.map.u' cannot be the target"), HasSubstr("nested"))));
}

TEST(DiagramBuilderTest, TheBuilderReachesPortsAtAnyDepth) {
  DiagramBuilder builder;
  auto& box = builder.Add<Box>("box", BoxParams{.connect_input = false});
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), box.map.u);
  builder.Connect(builder.AddFunction("other", Uses(), [] { return 2.0; }), box.in);
  auto& map = builder.Add<Map>("map", kSame);
  builder.Connect(box.map.y, map.u);
  EXPECT_EQ(builder.Build()->CreateContext()->Eval(map.y), box.map.params(1.0));
}

TEST(DiagramBuilderTest, WrongDirectionIsRefused) {
  DiagramBuilder builder;
  auto& a = builder.Add<Map>("a", kSame);
  auto& b = builder.Add<Map>("b", kSame);
  EXPECT_THAT(
      [&] { builder.Connect(a.u, b.u); },
      ThrowsMessage<BuildError>(AllOf(HasSubstr("'a.u' cannot be the source"), HasSubstr("direction"))));
  EXPECT_THAT([&] { builder.Connect(a.y, b.y); },
              ThrowsMessage<BuildError>(HasSubstr("'b.y' cannot be the target")));
}

TEST(DiagramBuilderTest, OutputOfNestedDiagramNeedsSomethingInside) {
  for (const bool read : {true, false}) {
    DiagramBuilder builder;
    auto& box = builder.Add<Box>("box", BoxParams{.connect_output = false});
    builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), box.in);
    if (read) builder.Connect(box.out, builder.Add<Map>("reader", kSame).u);
    EXPECT_THAT([&] { builder.Build(); },
                ThrowsMessage<BuildError>(AllOf(HasSubstr("output 'box.out'"), HasSubstr("nothing connected"),
                                                HasSubstr("connect an inner output to it"))));
  }
}

TEST(DiagramBuilderTest, NestedDiagramsPassValuesThroughTwoLevels) {
  DiagramBuilder builder;
  auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return t + 1; });
  auto& chest = builder.Add<Chest>("chest");
  auto& twice = builder.Add<Map>("twice", [](double u) { return 2 * u; });
  builder.Connect(clock, chest.in);
  builder.Connect(chest.out, twice.u);
  const auto diagram = builder.Build();
  const auto context = diagram->CreateContext();
  EXPECT_EQ(chest.box.map.path(), "chest.box.map");
  EXPECT_EQ(context->Eval(twice.y), 2);
  context->SetTime(2);
  EXPECT_EQ(context->Eval(chest.box.map.u), 3);
  EXPECT_EQ(context->Eval(twice.y), 6);
}

// ---- Names and parameters ----

TEST(DiagramBuilderTest, TwoBlocksOfOneNameAreRefused) {
  DiagramBuilder builder;
  builder.Add<Map>("pd", kSame);
  EXPECT_THAT(
      [&] { builder.Add<Map>("pd", kSame); },
      ThrowsMessage<BuildError>(AllOf(HasSubstr("two blocks named 'pd'"), HasSubstr("another name"))));
  class Twins final : public Subdiagram {
   public:
    Twins() { Add<Map>("twin", kSame), Add<Map>("twin", kSame); }
  };
  EXPECT_THAT(
      [&] { builder.Add<Twins>("twins"); },
      ThrowsMessage<BuildError>(AllOf(HasSubstr("inside 'twins': "), HasSubstr("two blocks named 'twin'"))));
}

TEST(DiagramBuilderTest, BadNamesAreRefused) {
  DiagramBuilder builder;
  for (const char* name : {"", "a.b", "a b", "a,b", "a\tb"}) {
    EXPECT_THAT(
        [&] { builder.Add<Map>(name, kSame); },
        ThrowsMessage<BuildError>(AllOf(HasSubstr("a block cannot be named '" + std::string(name) + "'"),
                                        HasSubstr("dots, commas and blanks"))));
  }
}

TEST(DiagramBuilderTest, RefusedParametersNameTheBlock) {
  DiagramBuilder builder;
  EXPECT_THAT([&] { builder.Add<Cart>("cart", CartParams{.mass = -1}); },
              ThrowsMessage<ParameterError>(testing::StrEq("block 'cart': mass must be positive")));
  class Train final : public Subdiagram {
   public:
    Train() { Add<Cart>("first", CartParams{.mass = 0}); }
  };
  EXPECT_THAT(
      [&] { builder.Add<Train>("train"); },
      ThrowsMessage<ParameterError>(testing::StrEq("block 'train': block 'first': mass must be positive")));
  EXPECT_TRUE(builder.blocks().empty());
}

// ---- Algebraic loops ----

TEST(DiagramBuilderTest, AlgebraicLoopNamesEveryHop) {
  DiagramBuilder builder;
  auto& before = builder.Add<Map>("before", kSame);  // leads into the loop, but is not of it
  auto& a = builder.Add<Map>("a", kSame);
  auto& box = builder.Add<Box>("box");
  auto& c = builder.Add<Map>("c", kSame);
  builder.Connect(a.y, before.u);
  builder.Connect(c.y, a.u);
  builder.Connect(a.y, box.in);
  builder.Connect(box.out, c.u);
  EXPECT_THAT([&] { builder.Build(); },
              ThrowsMessage<BuildError>(
                  AllOf(HasSubstr("algebraic loop: 'a.y' uses 'c.y' uses 'box.map.y' uses 'a.y'. Every hop"),
                        HasSubstr("a block that has state"))));
}

TEST(DiagramBuilderTest, LoopOfSampledBlocksIsOneAtDifferentRatesToo) {
  DiagramBuilder builder;
  auto& fast = builder.Add<SampledMap>("fast", SampledMapParams{kSame, {Hz(100)}});
  auto& slow = builder.Add<SampledMap>("slow", SampledMapParams{kSame, {Hz(10)}});
  builder.Connect(fast.y, slow.u);
  builder.Connect(slow.y, fast.u);
  EXPECT_THAT([&] { builder.Build(); }, ThrowsMessage<BuildError>(AllOf(
                                            HasSubstr("algebraic loop: 'fast.y' uses 'slow.y' uses 'fast.y'"),
                                            HasSubstr("a UnitDelay in front of one of the sampled inputs"))));
}

TEST(DiagramBuilderTest, LoopThroughASharedValueIsFound) {
  class Block final : public LeafSystem<void> {
   public:
    InputPort<double> u{this, "u"};
    Shared<double> twice{this, "twice", Uses(u), [](double u) { return 2 * u; }};
    OutputPort<double> y{this, "y", Uses(twice), kSame};
  };
  DiagramBuilder builder;
  auto& block = builder.Add<Block>("block");
  builder.Connect(block.y, block.u);
  EXPECT_THAT([&] { builder.Build(); },
              ThrowsMessage<BuildError>(HasSubstr("block.twice' uses 'block.y' uses")));
}

class Filter final : public LeafSystem<void> {
 public:
  InputPort<double> u{this, "u"};
  ContinuousState<double> x{this, "x", 3.0};
  OutputPort<double> slow{this, "slow", Uses(x), kSame};
  OutputPort<double> error{this, "error", Uses(x, u), [](double x, double u) { return u - x; }};
  TimeDerivative<double> dx{x, Uses(x, u), [](double x, double u) { return u - x; }};
};

TEST(DiagramBuilderTest, OutputsThatShowOnlyStateCloseNoLoop) {
  // Of the two outputs, one shows the state, the other feeds the input through. The former closes a loop.
  class Delay final : public LeafSystem<void> {
   public:
    InputPort<double> u{this, "u"};
    DiscreteState<double> d{this, "d", 1.0};
    OutputPort<double> y{this, d};
    Update<double> next{d, Sampled{Hz(10)}, Uses(u), kSame};
  };
  DiagramBuilder builder;
  auto& filter = builder.Add<Filter>("filter");
  auto& delay = builder.Add<Delay>("delay");
  auto& negate = builder.Add<Map>("negate", [](double u) { return -u; });
  builder.Connect(filter.slow, negate.u);
  builder.Connect(negate.y, filter.u);
  builder.Connect(delay.y, delay.u);
  const auto diagram = builder.Build();
  const auto context = diagram->CreateContext();
  EXPECT_EQ(context->Eval(filter.error), -6);
  EXPECT_EQ(context->Eval(delay.y), 1);
}

// ---- Declarations ----

TEST(DiagramBuilderTest, UseOfAnotherBlocksPortIsRefused) {
  class Thief final : public LeafSystem<const Map*> {
   public:
    explicit Thief(const Map* victim) : LeafSystem(victim) {}
    OutputPort<double> y{this, "y", Uses(params->y), kSame};
  };
  DiagramBuilder builder;
  auto& map = builder.Add<Map>("map", kSame);
  builder.Connect(builder.AddFunction("one", Uses(), [] { return 1.0; }), map.u);
  builder.Add<Thief>("thief", &map);
  EXPECT_THAT(
      [&] { builder.Build(); },
      ThrowsMessage<BuildError>(AllOf(HasSubstr("'thief.y' uses 'map.y', which belongs to another block"),
                                      HasSubstr("declare an input"))));
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

TEST(DiagramBuilderTest, EveryContinuousStateHasOneDerivative) {
  struct None final : LeafSystem<void> {
    ContinuousState<double> x{this, "x"};
  };
  EXPECT_THAT(BuildWith<Two>(), ThrowsMessage<BuildError>(HasSubstr("'block.x' has two time derivatives")));
  EXPECT_THAT(BuildWith<None>(),
              ThrowsMessage<BuildError>(AllOf(HasSubstr("'block.x' has no time derivative"),
                                              HasSubstr("declare a TimeDerivative"))));
}

struct HalfDescribed {
  double a = 0, b = 0;
  static FieldList Fields() { return {{"a", &HalfDescribed::a}, Undescribed(&HalfDescribed::b)}; }
};

TEST(DiagramBuilderTest, ContinuousStateListsAllItsMembers) {
  struct Block final : LeafSystem<void> {
    ContinuousState<HalfDescribed> x{this, "x"};
    TimeDerivative<HalfDescribed> dx{x, Uses(x), [](const HalfDescribed& x) { return x; }};
  };
  EXPECT_THAT(BuildWith<Block>(), ThrowsMessage<BuildError>(AllOf(
                                      HasSubstr("'block.x'"), HasSubstr("list all members in Fields()"))));
}

TEST(DiagramBuilderTest, OffsetNeedsAnInitialValue) {
  struct Block final : LeafSystem<void> {
    OutputPort<double> y{this, "y", Sampled{Hz(10), 0.05}, Uses(time), kSame};
  };
  EXPECT_THAT(BuildWith<Block>(),
              ThrowsMessage<BuildError>(AllOf(HasSubstr("'block.y' first runs at t = 0.05 s"),
                                              HasSubstr("no initial value: declare one before Sampled"))));
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

TEST(DiagramBuilderTest, TwoUpdatesOfOneStateAndTriggerAreRefused) {
  EXPECT_THAT(
      BuildWith<TwoRates>(),
      ThrowsMessage<BuildError>(AllOf(HasSubstr("'block.n' has two sampled updates"), HasSubstr("merge"))));
  EXPECT_THAT(BuildWith<TwoStarts>(),
              ThrowsMessage<BuildError>(HasSubstr("'block.n' has two updates with the same trigger")));
  EXPECT_NO_THROW(BuildWith<Different>()());
}

struct Block final : LeafSystem<void> {
  Scratch<double> warm{this, "warm"};
  OutputPort<double> y{this, "y", Uses(warm), [](double& w) { return w; }};
  OutputPort<double> z{this, "z", Uses(warm), [](double& w) { return w; }};
};

TEST(DiagramBuilderTest, ScratchBelongsToOneCalculation) {
  EXPECT_THAT(BuildWith<Block>(),
              ThrowsMessage<BuildError>(AllOf(HasSubstr("scratch 'block.warm' is used by both 'y' and 'z'"),
                                              HasSubstr("belongs to one calculation"))));
}

TEST(DiagramBuilderTest, RandomNumbersAreForSampledCalculations) {
  struct Block final : LeafSystem<void> {
    Random random{this, "random"};
    OutputPort<double> y{this, "y", Uses(random), [](RandomStream& r) { return r.Normal(); }};
  };
  EXPECT_THAT(BuildWith<Block>(),
              ThrowsMessage<BuildError>(AllOf(HasSubstr("'block.y' uses the random stream 'random'"),
                                              HasSubstr("declare it Sampled"))));
}

TEST(DiagramBuilderTest, IncommensurableRatesAreRefused) {
  DiagramBuilder builder;
  builder.Add<Counter>("a", Sampled{Rate::FromPeriod(1, 999983)});
  builder.Add<Counter>("b", Sampled{Rate::FromPeriod(1, 999979)});
  builder.Add<Counter>("c", Sampled{Rate::FromPeriod(1, 999961)});
  EXPECT_THAT([&] { builder.Build(); }, ThrowsMessage<BuildError>(AllOf(
                                            HasSubstr("'a.next n'"), HasSubstr("'c.next n'"),
                                            HasSubstr("no common tick"), HasSubstr("round their periods"))));
}

TEST(DiagramBuilderTest, RatesMayMeetSeldom) {
  DiagramBuilder builder;
  auto& a = builder.Add<Counter>("a", Sampled{Rate::FromPeriod(1, 99991)});
  auto& b = builder.Add<Counter>("b", Sampled{Rate::FromPeriod(100003, 1000000)});
  auto& c = builder.Add<Counter>("c", Sampled{Rate::FromPeriod(1, 1000)});
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(a.n), 99992);
  EXPECT_EQ(simulator.context().Eval(b.n), 10);
  EXPECT_EQ(simulator.context().Eval(c.n), 1001);
}

TEST(DiagramBuilderTest, AHundredRatesAreNotTooMany) {
  DiagramBuilder builder;
  std::vector<Counter*> counters;
  for (int i = 1; i <= 100; ++i)
    counters.push_back(&builder.Add<Counter>("every_" + std::to_string(i), Sampled{Rate(i, 1000)}));
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(1);
  for (int i = 1; i <= 100; ++i) EXPECT_EQ(simulator.context().Eval(counters[i - 1]->n), 1000 / i + 1);
}

// ---- Functions as blocks ----

TEST(DiagramBuilderTest, FunctionsOfSeveralPortsAndTime) {
  DiagramBuilder builder;
  auto& two = builder.AddFunction("two", Uses(), [] { return 2.0; });
  auto& vector = builder.AddFunction({"vector", "N", "left, right"}, Uses(two, builder.time),
                                     [](double a, double t) { return Vec<2>(a, t); });
  auto& sum = builder.AddFunction("sum", Uses(two, vector, two),
                                  [](double a, const Vec<2>& v, double b) { return a + v.sum() + b; });
  auto& held = builder.AddFunction("held", Sampled{Hz(10)}, Uses(sum), kSame);
  const auto diagram = builder.Build();
  EXPECT_EQ(vector.path(), "vector.output");
  EXPECT_EQ(vector.elements()[1].name, "right");
  EXPECT_EQ(vector.elements()[1].unit, "N");
  Simulator simulator(*diagram);
  simulator.RunTo(0.25);
  EXPECT_EQ(simulator.context().Eval(sum), 2 + 2 + 0.25 + 2);
  EXPECT_EQ(simulator.context().Eval(held), 2 + 2 + 0.2 + 2);
}

TEST(DiagramBuilderTest, FunctionsInsideANestedDiagramUseItsInputs) {
  class Squarer final : public Subdiagram {
   public:
    Squarer() {
      Connect(AddFunction("square", Uses(in, in), [](double a, double b) { return a * b; }), out);
    }
    InputPort<double> in{this, "in"};
    OutputPort<double> out{this, "out"};
  };
  DiagramBuilder builder;
  auto& squarer = builder.Add<Squarer>("squarer");
  builder.Connect(builder.AddFunction("three", Uses(), [] { return 3.0; }), squarer.in);
  const auto diagram = builder.Build();
  EXPECT_EQ(diagram->CreateContext()->Eval(squarer.out), 9);
}

// ---- Ports known at run time only ----

TEST(DiagramBuilderTest, ListsOfInputs) {
  class Sum final : public LeafSystem<std::size_t> {
   public:
    explicit Sum(std::size_t size) : LeafSystem(size) {}
    InputPorts<double> u{this, "u", params};
    OutputPort<double> y{this, "y", Uses(u, time), [](const Inputs<double>& u, double t) {
                           double sum = t;
                           for (std::size_t i = 0; i < u.size(); ++i) sum += u[i];
                           return sum;
                         }};
  };
  DiagramBuilder builder;
  auto& sum = builder.Add<Sum>("sum", 3);
  for (int i = 0; i < 3; ++i) {
    builder.Connect(builder.AddFunction("f" + std::to_string(i), Uses(), [i] { return std::pow(10, i); }),
                    sum.u[i]);
  }
  const auto diagram = builder.Build();
  EXPECT_EQ(sum.u[2].name(), "u_2");
  EXPECT_EQ(diagram->CreateContext()->Eval(sum.y), 111);
}

TEST(DiagramBuilderTest, UndeclaredReadAtRunTimeIsNamed) {
  class Chooser final : public LeafSystem<bool> {
   public:
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
  DiagramBuilder builder;
  auto& good = builder.Add<Chooser>("good", true);
  auto& bad = builder.Add<Chooser>("bad", false);
  const auto diagram = builder.Build();
  const auto context = diagram->CreateContext();
  EXPECT_EQ(context->Eval(good.y), 3);
  EXPECT_THAT([&] { context->Eval(bad.y); },
              ThrowsMessage<RunError>(AllOf(HasSubstr("'bad.y' failed"), HasSubstr("reads 'bad.b'"),
                                            HasSubstr("declared only [a]"), HasSubstr("UsesAtRunTime"))));
}

// ---- Looking things up ----

TEST(DiagramBuilderTest, FindGivesTheNearestName) {
  DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart");
  auto& pd = builder.Add<Pd>("pd");
  builder.Connect(cart.state, pd.x);
  builder.Connect(pd.u, cart.force);
  const auto diagram = builder.Build();
  EXPECT_EQ(&diagram->Find("pd.u"), &pd.u);
  EXPECT_EQ(&diagram->FindBlock("cart"), &cart);
  EXPECT_THAT([&] { diagram->Find("pd.v"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("no signal 'pd.v'"), HasSubstr("did you mean 'pd."))));
  EXPECT_THAT([&] { diagram->FindBlock("card"); }, ThrowsMessage<Error>(HasSubstr("did you mean 'cart'?")));
  EXPECT_THAT(diagram->ContinuousStateNames(), ElementsAre("cart.x.position", "cart.x.velocity"));
}

}  // namespace
}  // namespace tenon::diagram_builder_test
