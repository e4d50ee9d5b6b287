// Programs that compile but are refused at run time because they would not do what they say.

#include <tenon/systems/analysis/analysis.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::wrong_programs_test {

template <class Block, class... Args>
auto Adding(Args&&... args) {
  return [=] { DiagramBuilder().Add<Block>("block", args...); };
}

// ---- Members used above their declaration ----

struct UsesInputsBelow final : LeafSystem<void> {
  OutputPort<double> y{this, "y", Uses(time, u), [](double, const Inputs<double>& u) { return u[0]; }};
  InputPorts<double> u{this, "u", 1};
};

struct ShowsStateBelow final : LeafSystem<void> {
  OutputPort<double> y{this, x};
  ContinuousState<double> x{this, "x"};
  TimeDerivative<double> dx{x, Uses(x), [](double x) { return -x; }};
};

struct DerivativeOfStateBelow final : LeafSystem<void> {
  TimeDerivative<double> dx{x, Uses(), [] { return 1.0; }};
  ContinuousState<double> x{this, "x"};
};

struct UpdateOfStateBelow final : LeafSystem<void> {
  Update<double> next{s, Sampled{Hz(1)}, Uses(), [] { return 1.0; }};
  DiscreteState<double> s{this, "s"};
};

struct UpdateByWitnessBelow final : LeafSystem<void> {
  DiscreteState<double> s{this, "s"};
  Update<double> next{s, zero, Uses(), [] { return 1.0; }};
  Witness zero{this, "zero", Crossing::kBoth, Uses(time), [](double t) { return t - 1; }};
};

struct FunctionOfInputBelow final : Subdiagram {
  const OutputPort<double>& y = AddFunction("twice", Uses(u), [](double u) { return 2 * u; });
  InputPort<double> u{this, "u"};
};

using WrongProgramsTest = DiagramTest;

TEST_F(WrongProgramsTest, MembersAreDeclaredBeforeTheyAreUsed) {
  EXPECT_TRUE(Throws<BuildError>(Adding<UsesInputsBelow>(), "'block'", "'y'"));
  EXPECT_TRUE(Throws<BuildError>(Adding<ShowsStateBelow>(), "'block'", "move"));
  EXPECT_TRUE(Throws<BuildError>(Adding<DerivativeOfStateBelow>(), "'block'", "move"));
  EXPECT_TRUE(Throws<BuildError>(Adding<UpdateOfStateBelow>(), "'block'", "move"));
  EXPECT_TRUE(Throws<BuildError>(Adding<UpdateByWitnessBelow>(), "'block'", "move"));
  EXPECT_TRUE(Throws<BuildError>(Adding<FunctionOfInputBelow>(), "'block'", "'twice'"));
}

// ---- Lambdas that a compiler confuses ----

TEST_F(WrongProgramsTest, LambdasOfALocalClassAreToldApartOrRefused) {
  struct Local final : LeafSystem<void> {
    OutputPort<double> one{this, "one", Uses(time), [](double) { return 1.0; }};
    OutputPort<double> two{this, "two", Uses(time), [](double) { return 2.0; }};
  };
  try {
    auto& block = builder.Add<Local>("block");
    const auto context = builder.Build()->CreateContext();
    EXPECT_EQ(context->Eval(block.one), 1);
    EXPECT_EQ(context->Eval(block.two), 2);
  } catch (const BuildError& error) {
    EXPECT_NE(std::string(error.what()).find("another member"), std::string::npos) << error.what();
  }
}

// ---- Units, names, sizes ----

struct Emitter final : LeafSystem<Spec> {
  explicit Emitter(Spec spec) : LeafSystem(std::move(spec)) {}
  OutputPort<double> y{this, params, Uses(), [] { return 1.0; }};
};

struct Receiver final : LeafSystem<Spec> {
  explicit Receiver(Spec spec) : LeafSystem(std::move(spec)) {}
  InputPort<double> u{this, params};
};

struct Wrapper final : Subdiagram {
  InputPort<double> u{this, "u"};
  Wrapper() { Connect(u, Add<Receiver>("receiver", Spec("force", "N")).u); }
};

TEST_F(WrongProgramsTest, AnEmptyUnitMeansAnyAndPassesTheUnitOn) {
  auto& angle = builder.Add<Emitter>("angle", Spec("angle", "rad"));
  auto& wrapper = builder.Add<Wrapper>("wrapper");
  builder.Connect(angle.y, wrapper.u);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'angle.angle'", "'wrapper.receiver.force'"));

  DiagramBuilder any;
  auto& source = any.Add<Emitter>("source", Spec("y", "rad"));
  auto& sink = any.Add<Receiver>("sink", Spec("u"));
  any.Connect(source.y, sink.u);
  EXPECT_NO_THROW(any.Build());
}

TEST_F(WrongProgramsTest, WhoMeansItCanIgnoreUnits) {
  auto& angle = builder.Add<Emitter>("angle", Spec("angle", "rad"));
  builder.Connect(angle.y, builder.Add<Receiver>("force", Spec("force", "N")).u, IgnoreUnits{});
  EXPECT_NO_THROW(builder.Build());
}

struct Specified final : LeafSystem<Spec> {
  explicit Specified(Spec spec) : LeafSystem(std::move(spec)) {}
  OutputPort<Vec<3>> y{this, params, Uses(), [] { return Vec<3>(1, 2, 3); }};
};

TEST_F(WrongProgramsTest, UnitsAndNamesAreAsManyAsElements) {
  const auto building = [](const Spec& spec) {
    return [spec] {
      DiagramBuilder fresh;
      fresh.Add<Specified>("block", spec);
      fresh.Build();
    };
  };
  EXPECT_TRUE(Throws<BuildError>(building({"y", "m, m/s"}), "'block.y'"));
  EXPECT_TRUE(Throws<BuildError>(building({"y", "m, m, m, m"}), "3 elements but 4 units"));
  EXPECT_TRUE(Throws<BuildError>(building({"y", "m", "a, b"}), "'block.y'"));
  EXPECT_NO_THROW(building({"y", "m"})());
  EXPECT_NO_THROW(building({"y", "m, m, rad", "a, b, c"})());
}

struct Items final : LeafSystem<Spec> {
  explicit Items(Spec spec) : LeafSystem(std::move(spec)) {}
  OutputPort<std::array<double, 2>> y{this, params, Uses(), [] { return std::array{1.0, 2.0}; }};
};

TEST_F(WrongProgramsTest, NamesOfAnArrayAreAsManyAsItsItems) {
  builder.Add<Items>("block", Spec("y", "m", "a, b, c"));
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'block.y'"));
  DiagramBuilder other;
  other.Add<Items>("block", Spec("y", "m", "a, b"));
  EXPECT_NO_THROW(other.Build());
}

struct TwoOfThree {
  Vec<3> p = Vec<3>::Zero();
  static FieldList Fields() { return {{"p", &TwoOfThree::p, "m", "x, y"}}; }
};

TEST_F(WrongProgramsTest, NamesInAStructAreAsManyAsElements) {
  EXPECT_TRUE(Throws<BuildError>([] { internal::TypeInfoOf<TwoOfThree>(); }, "'p'"));
}

struct Pair {
  double a = 0, b = 0;
  static FieldList Fields() { return {{"a", &Pair::a, "m"}, {"b", &Pair::b, "s"}}; }
};

TEST_F(WrongProgramsTest, AStructBringsItsOwnUnits) {
  struct Block final : LeafSystem<void> {
    OutputPort<Pair> y{this, {"y", "m"}, Uses(), [] { return Pair(); }};
  };
  builder.Add<Block>("block");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'block.y'"));
}

struct Twice final : LeafSystem<void> {
  InputPort<double> first{this, "u", 0.0};
  InputPort<double> second{this, "u", 0.0};
};

TEST_F(WrongProgramsTest, MembersHaveDifferentNamesThatCanBeWritten) {
  builder.Add<Twice>("block");
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'block'", "'u'"));
  for (const char* name : {"", "a.b", "a,b", "a b", "a\"b", "a'b"}) {
    DiagramBuilder named;
    named.Add<Emitter>("block", Spec(name, "m"));
    EXPECT_TRUE(Throws<BuildError>([&] { named.Build(); }, "'block'", "'" + std::string(name)));
  }
}

TEST_F(WrongProgramsTest, AnOutputCanShowAStateByItsOwnName) {
  struct Tank final : LeafSystem<void> {
    ContinuousState<double> x{this, {"x", "m"}, 2.0};
    OutputPort<double> level{this, {"level"}, x};
    TimeDerivative<double> dx{x, Uses(), [] { return 0.0; }};
  };
  auto& tank = builder.Add<Tank>("tank");
  const auto diagram = builder.Build();
  EXPECT_EQ(tank.level.path(), "tank.level");
  EXPECT_EQ(tank.level.spec().units, "m");
  EXPECT_EQ(diagram->CreateContext()->Eval(tank.level), 2);
}

TEST_F(WrongProgramsTest, SizesThatAreKnownMustAgree) {
  struct Wide final : LeafSystem<void> {
    OutputPort<Eigen::MatrixXd> y{this, "y", Eigen::MatrixXd::Zero(2, 3), Uses(),
                                  [](Eigen::MatrixXd* y) { y->setOnes(2, 3); }};
  };
  struct Reader final : LeafSystem<Eigen::MatrixXd> {
    using LeafSystem::LeafSystem;
    InputPort<Eigen::MatrixXd> u{this, "u", params};
  };
  auto& wide = builder.Add<Wide>("wide");
  builder.Connect(wide.y, builder.Add<Reader>("high", Eigen::MatrixXd::Zero(3, 2)).u);
  builder.Connect(wide.y, builder.Add<Reader>("short", Eigen::MatrixXd::Zero(2, 1)).u);
  EXPECT_TRUE(
      Throws<BuildError>([&] { builder.Build(); }, "'wide.y'", "'high.u'", "3 x 2", "'short.u'", "2 x 1"));
}

// ---- Building ----

TEST_F(WrongProgramsTest, AllFaultsAreInOneMessage) {
  for (const char* name : {"a", "b", "c", "d", "e"}) builder.Add<Cart>(name);
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Build(); }, "'a.force'", "'b.force'", "'c.force'", "'d.force'",
                                 "'e.force'"));
}

TEST_F(WrongProgramsTest, ABuilderWhoseDiagramWasRefusedCanBeMended) {
  auto& cart = builder.Add<Cart>("cart");
  EXPECT_THROW(builder.Build(), BuildError);
  EXPECT_EQ(cart.path(), "cart");
  builder.Connect(builder.AddFunction({"force", "N"}, Uses(), [] { return 4.0; }), cart.force);
  EXPECT_NEAR(ValueAt(1, builder, cart.state)[0], 1, 1e-9);
}

// ---- Contexts ----

TEST_F(WrongProgramsTest, SetRefusesAConnectedInput) {
  auto& a = builder.Add<Oscillator>("a");
  auto& b = builder.Add<Receiver>("b", Spec("u"));
  builder.Connect(builder.AddFunction("q", Uses(a.state), [](const Vec<2>& x) { return x[0]; }), b.u);
  const auto context = builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { context->Set(b.u, 3.0); }, "'b.u'", "'q.output'"));
  EXPECT_EQ(context->Eval(a.x)[0], 1);
}

TEST_F(WrongProgramsTest, AConstContextCanBeEvaluatedAndDoesNotChange) {
  int calls = 0;
  auto& plant = builder.Add<Oscillator>("plant");
  auto& twice = builder.AddFunction("twice", Uses(plant.state), [&calls](const Vec<2>& x) {
    ++calls;
    return 2 * x[0];
  });
  const auto context = builder.Build()->CreateContext();
  const Context& constant = *context;
  EXPECT_EQ(constant.Eval(twice), 2);
  EXPECT_EQ(constant.Eval(twice), 2);
  EXPECT_EQ(calls, 2);  // each in a clone
  EXPECT_EQ(context->Eval(twice), 2);
  EXPECT_EQ(constant.Eval(twice), 2);
  EXPECT_EQ(calls, 3);  // known by then
}

// ---- Runs ----

struct Exhausted : std::runtime_error {
  using std::runtime_error::runtime_error;
  int battery = 7;
};

TEST_F(WrongProgramsTest, AnExceptionOfTheUsersTypeIsNestedInOurs) {
  auto& plant = builder.Add<Oscillator>("plant");
  builder.Connect(builder.AddFunction("drive", Sampled{Hz(10)}, Uses(builder.time),
                                      [](double t) -> double {
                                        if (t > 0.25) throw Exhausted("the battery is empty");
                                        return 0;
                                      }),
                  plant.u);
  Simulator simulator(*builder.Build());
  try {
    simulator.RunTo(1);
    FAIL() << "no exception";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("'drive.output' failed at t = 0.3 s: the battery is empty"),
              std::string::npos)
        << error.what();
    try {
      std::rethrow_if_nested(error);
      FAIL() << "nothing is nested";
    } catch (const Exhausted& own) {
      EXPECT_EQ(own.battery, 7);
    }
  }
}

TEST_F(WrongProgramsTest, ARunThatFailedRefusesToGoOnUntilASnapshotIsRestored) {
  bool fails = true;
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10)});
  builder.AddFunction("fuse", Sampled{Hz(10)}, Uses(builder.time), [&fails](double t) {
    if (fails && t > 0.25) throw std::runtime_error("blown");
    return t;
  });
  Simulator simulator(builder.Build());
  simulator.RunTo(0.2);
  const auto snapshot = simulator.context().Save();
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "blown"));
  fails = false;
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "blown"));
  EXPECT_TRUE(Throws<RunError>([&] { simulator.context().Save(); }, "cannot be saved"));
  Simulator clone(simulator.context().Clone());
  EXPECT_THROW(clone.RunTo(1), RunError);
  simulator.context().Restore(snapshot);
  simulator.RunTo(1);
  EXPECT_EQ(simulator.context().Eval(counter.n), 11);
}

TEST_F(WrongProgramsTest, ASeedForAContextThatExistsIsRefused) {
  builder.Add<Oscillator>("plant");
  const auto diagram = builder.Build();
  EXPECT_TRUE(Throws<ParameterError>([&] { Simulator(diagram->CreateContext(3), {.seed = 9}); },
                                     "Diagram::CreateContext"));
  EXPECT_NO_THROW(Simulator(diagram->CreateContext(9), {.seed = 9}));
  EXPECT_EQ(Simulator(*diagram, {.seed = 9}).context().seed(), 9);
}

TEST_F(WrongProgramsTest, ManyLogsAtOneRate) {
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(1000)});
  Simulator simulator(builder.Build());
  std::vector<std::shared_ptr<MemoryLog>> logs;
  for (int i = 0; i < 65; ++i) logs.push_back(simulator.AddLog(Hz(100), {&counter.n}));
  simulator.RunTo(2);
  for (const auto& log : logs) EXPECT_EQ(log->rows(), 201);
}

TEST_F(WrongProgramsTest, LinearizeRefusesADiagramOfSamplesAlone) {
  builder.Add<Counter>("counter", Sampled{Hz(10)});
  const auto context = builder.Build()->CreateContext();
  EXPECT_TRUE(
      Throws<RunError>([&] { Linearize(*context, {}, {}); }, "no continuous state", "use LinearizeDiscrete"));
}

// ---- Memory ----

struct Unwritten {
  double a = 0;
  std::array<Vec<3>, 4> feet_W{};  // braces do not make an Eigen matrix zero
  static FieldList Fields() { return {{"a", &Unwritten::a}, {"feet_W", &Unwritten::feet_W}}; }
};
struct UnwrittenNumber {
  double a;
  static FieldList Fields() { return {{"a", &UnwrittenNumber::a}}; }
};

template <class T>
struct Emits final : LeafSystem<void> {
  OutputPort<T> y{this, "y", Uses(), [] { return T(); }};
};

TEST_F(WrongProgramsTest, AStructWhoseMembersBeginAsWhateverLiesInMemoryIsRefused) {
#ifndef EIGEN_INITIALIZE_MATRICES_BY_NAN  // which writes them
  EXPECT_TRUE(Throws<BuildError>(Adding<Emits<Unwritten>>(), "'block'", "'feet_W'", "Unwritten"));
#endif
  EXPECT_TRUE(Throws<BuildError>(Adding<Emits<UnwrittenNumber>>(), "'a'", "UnwrittenNumber"));
}

TEST_F(WrongProgramsTest, SnapshotsOfEqualContextsAreEqualBytes) {
  // The padding between the members does not count.
  struct Padded {
    bool flag = false;
    double value = 0;
    static FieldList Fields() { return {{"flag", &Padded::flag}, {"value", &Padded::value}}; }
  };
  struct Block final : LeafSystem<void> {
    DiscreteState<Padded> state{this, "state"};
  };
  auto& block = builder.Add<Block>("block");
  const auto diagram = builder.Build();
  const auto one = diagram->CreateContext(), other = diagram->CreateContext();
  const auto set = [&](Context& context, int content) {
    alignas(Padded) std::byte memory[sizeof(Padded)];
    std::fill(std::begin(memory), std::end(memory), static_cast<std::byte>(content));
    auto* value = new (memory) Padded;
    value->flag = true;
    value->value = 2;
    context.Set(block.state, *value);
  };
  set(*one, 0x11);
  set(*other, 0xee);
  EXPECT_EQ(one->Save(), other->Save());
}

}  // namespace tenon::wrong_programs_test
