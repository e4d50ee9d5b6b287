// States whose size is known at run time only.

#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::run_time_sizes_test {

/// x_i' = -i x_i + u from 1, for i = 1 … n; at t = 1 the first is set to 5.
struct DecayParams {
  Eigen::Index size = 3;
  Eigen::Index wrong = 0;  ///< elements too many in the derivative
};
struct Decay final : LeafSystem<DecayParams> {
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, "u", 0.0};
  ContinuousState<Eigen::VectorXd> x{this, {"x", "m"}, Eigen::VectorXd::Ones(params.size)};
  OutputPort<Eigen::VectorXd> state{this, x};
  TimeDerivative<Eigen::VectorXd> dx{x, Uses(x, u),
                                     [this](const Eigen::VectorXd& x, double u, Eigen::VectorXd* dx) {
                                       dx->resize(x.size() + params.wrong);
                                       dx->setZero();
                                       for (Eigen::Index i = 0; i < x.size(); ++i)
                                         (*dx)[i] = -static_cast<double>(i + 1) * x[i] + u;
                                     }};
  Update<Eigen::VectorXd> reset{x, Sampled{Hz(1), 1.0}, Uses(x),
                                [](const Eigen::VectorXd& x, Eigen::VectorXd* next) {
                                  *next = x;
                                  (*next)[0] = 5;
                                }};
};

TEST(RunTimeSizesTest, StatesAreIntegratedUpdatedLoggedAndNamed) {
  for (const Eigen::Index size : {1, 3, 12}) {
    for (const Method method : {Method::kErk, Method::kBdf}) {
      DiagramBuilder builder;
      auto& decay = builder.Add<Decay>("decay", {.size = size});
      builder.Add<Oscillator>("other");
      const auto diagram = builder.Build();
      ASSERT_EQ(diagram->num_continuous_states(), size + 2);
      EXPECT_EQ(diagram->ContinuousStateNames()[static_cast<std::size_t>(size)], "other.x.q");
      Simulator simulator(*diagram, {.method = method, .rtol = 1e-9, .atol = 1e-11});
      const auto log = simulator.AddLog(Hz(10), {&decay.state});
      simulator.RunTo(1.5);
      const Eigen::VectorXd& x = simulator.context().Eval(decay.x);
      ASSERT_EQ(x.size(), size);
      EXPECT_NEAR(x[0], 5 * std::exp(-0.5), 1e-6);
      for (Eigen::Index i = 1; i < size; ++i)
        EXPECT_NEAR(x[i], std::exp(-1.5 * static_cast<double>(i + 1)), 1e-7);
      EXPECT_EQ(x, simulator.context().continuous_state().head(size));
      EXPECT_NEAR(log->row(5)[1], std::exp(-0.5), 1e-7);
    }
  }
}

TEST(RunTimeSizesTest, StatesAreSetClonedAndSaved) {
  TestRig<Decay> rig({.size = 2});
  rig.Set(rig->x, Eigen::Vector2d(3, 4));
  EXPECT_EQ(rig.context().continuous_state(), Eigen::Vector2d(3, 4));
  const auto bytes = rig.context().Save();
  const auto clone = rig.context().Clone();
  clone->SetContinuousState(Eigen::Vector2d(7, 8));
  EXPECT_EQ(clone->Eval(rig->x), Eigen::Vector2d(7, 8));
  EXPECT_EQ(rig[rig->x], Eigen::Vector2d(3, 4));
  clone->Restore(bytes);
  EXPECT_EQ(clone->Eval(rig->x), Eigen::Vector2d(3, 4));
  EXPECT_EQ(clone->continuous_state(), Eigen::Vector2d(3, 4));
  rig.Fix(rig->u, 1);
  EXPECT_EQ(rig.Derivative(rig->x), Eigen::Vector2d(-2, -7));
  EXPECT_EQ(rig.context().EvalTimeDerivatives(), Eigen::Vector2d(-2, -7));
}

TEST(RunTimeSizesTest, SizesAreThoseOfTheInitialValue) {
  TestRig<Decay> rig({.size = 2});
  EXPECT_TRUE(Throws<RunError>([&] { rig.Set(rig->x, Eigen::Vector3d(1, 2, 3)); }, "'block.x'"));
  TestRig<Decay> wrong({.size = 2, .wrong = 1});
  EXPECT_TRUE(Throws<RunError>([&] { wrong.RunTo(0.1); }, "'block.d/dt x' has 3", "its state has 2"));
}

/// Gives `given` elements where `declared` are declared; 0: none.
struct VectorParams {
  Eigen::Index given = 2, declared = 0;
};
struct Vector final : LeafSystem<VectorParams> {
  using LeafSystem::LeafSystem;
  OutputPort<Eigen::VectorXd> y{this, "y", Eigen::VectorXd::Zero(params.declared), Uses(),
                                [this] { return Eigen::VectorXd(Eigen::VectorXd::Ones(params.given)); }};
};
/// Reads the last element.
struct Reader final : LeafSystem<Eigen::Index> {
  using LeafSystem::LeafSystem;
  InputPort<Eigen::VectorXd> u{this, "u", OfSize(params)};
  OutputPort<double> last{this, "last", Uses(u), [this](const Eigen::VectorXd& u) { return u[params - 1]; }};
};

TEST(RunTimeSizesTest, AnotherSizeThanDeclaredIsRefusedWhereItArises) {
  TestRig<Vector> rig({.given = 2, .declared = 31});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'", "2 x 1", "31 x 1"));
  DiagramBuilder builder;
  auto& vector = builder.Add<Vector>("vector", {.given = 2});
  auto& reader = builder.Add<Reader>("reader", Eigen::Index{31});
  builder.Connect(vector.y, reader.u);
  const auto context = builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { context->Eval(reader.last); }, "'vector.y'", "2 x 1", "'reader.u'"));
  TestRig<Reader> alone(Eigen::Index{31});
  EXPECT_TRUE(Throws<RunError>([&] { alone.Fix(alone->u, Eigen::Vector2d(1, 2)); }, "'block.u'", "31 x 1"));
  EXPECT_NO_THROW(alone.Fix(alone->u, Eigen::VectorXd::Ones(31)));
}

TEST(RunTimeSizesTest, TheSizeOfAFunctionIsThatOfItsModel) {
  const auto two = [] { return Eigen::VectorXd(Eigen::VectorXd::Ones(2)); };
  DiagramBuilder builder;
  auto& right = builder.AddFunction("right", Eigen::VectorXd::Zero(2), Uses(), two);
  auto& wrong = builder.AddFunction("wrong", Eigen::VectorXd::Zero(3), Uses(), two);
  auto& held = builder.AddFunction("held", Eigen::VectorXd::Zero(2), Sampled{Hz(1), 0.5}, Uses(), two);
  EXPECT_EQ(held.elements().size(), 2U);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.1);
  EXPECT_EQ(simulator.context().Eval(right), Eigen::Vector2d(1, 1));
  EXPECT_EQ(simulator.context().Eval(held), Eigen::Vector2d(0, 0));
  EXPECT_TRUE(Throws<RunError>([&] { simulator.context().Eval(wrong); }, "'wrong.output'", "3 x 1"));
  DiagramBuilder delayed;
  delayed.Connect(delayed.AddFunction("two", Uses(), two),
                  delayed.Add<SampleDelay<Eigen::VectorXd>>("delay", {.samples = 3}).u);
  EXPECT_TRUE(Throws<BuildError>([&] { delayed.Build(); }, "'delay.y'", "`initial`"));
}

// Values that several calculations and several blocks share.
using ::testing::ElementsAre, ::testing::IsEmpty;

int calls = 0;

/// Multiplies by a factor and counts how often.
struct Times {
  double factor;
  double operator()(double u) const {
    ++calls;
    return factor * u;
  }
  friend bool operator==(const Times&, const Times&) = default;
};

/// Two outputs that share u times a factor; the second one also through a value that builds on the first.
struct Scaled final : LeafSystem<double> {
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, "u"};
  Shared<double> once{this, "once", Uses(u), Times{params}};
  Shared<double> twice{this, "twice", Uses(once), Times{params}};
  OutputPort<double> y{this, "y", Uses(once), [](double once) { return once + 1; }};
  OutputPort<double> z{this, "z", Uses(twice), [](double twice) { return twice; }};
};

struct SharedTest : ::testing::Test {
  Scaled& AddScaled(const std::string& name, double factor, const OutputPort<double>& source) {
    auto& block = builder_.Add<Scaled>(name, factor);
    builder_.Connect(source, block.u);
    return block;
  }
  const OutputPort<double>& AddClock(const std::string& name) {
    return builder_.AddFunction(name, Uses(builder_.time), [](double t) { return 1 + t; });
  }
  DiagramBuilder builder_;
};

TEST_F(SharedTest, EqualFunctionsOfOneValueAreComputedOnceForAllBlocks) {
  const auto& clock = AddClock("clock");
  const Scaled &a = AddScaled("a", 2, clock), &b = AddScaled("b", 2, clock);
  const auto context = builder_.Build()->CreateContext();
  calls = 0;
  EXPECT_EQ(context->Eval(a.y), 3);
  EXPECT_EQ(context->Eval(b.y), 3);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(context->Eval(b.z), 4);  // a value that builds on a shared one is shared too
  EXPECT_EQ(context->Eval(a.z), 4);
  EXPECT_EQ(calls, 2);
}

TEST_F(SharedTest, OtherFunctionsOrValuesAreComputedApart) {
  const auto &clock = AddClock("clock"), &other = AddClock("other");
  const Scaled &a = AddScaled("a", 2, clock), &b = AddScaled("b", 3, clock), &c = AddScaled("c", 2, other);
  const auto context = builder_.Build()->CreateContext();
  calls = 0;
  EXPECT_EQ(context->Eval(a.y), 3);
  EXPECT_EQ(context->Eval(b.y), 4);
  EXPECT_EQ(context->Eval(c.y), 3);
  EXPECT_EQ(calls, 3);
}

// Properties of ports and states that tools read.
TEST(SourceTest, TellsItsType) {
  const Cart cart;
  EXPECT_EQ(cart.force.type_name(), "double");
  EXPECT_EQ(cart.state.type_name(), "Vec<2>");
  EXPECT_EQ(cart.state.type().kind, internal::TypeInfo::Kind::kMatrix);
}

TEST(SourceTest, TellsWhetherItMustBeConnected) {
  const Pd pd;
  EXPECT_FALSE(pd.x.is_optional());
  EXPECT_TRUE(pd.ref.is_optional());
  EXPECT_FALSE(pd.u.is_optional());
  EXPECT_THAT(pd.ref.initial_numbers(), ElementsAre(0));
}

TEST(SourceTest, TellsWhereAStateBegins) {
  const Oscillator oscillator;
  EXPECT_THAT(oscillator.x.initial_numbers(), ElementsAre(1, 0));
}

TEST(SourceTest, TellsWhatItUsesAndWhatItIsFor) {
  const Cart cart;
  EXPECT_THAT(cart.dx.uses(), ElementsAre(&cart.x, &cart.force));
  EXPECT_EQ(cart.dx.target(), &cart.x);
  EXPECT_THAT(cart.x.uses(), IsEmpty());
  EXPECT_EQ(cart.x.target(), nullptr);
}

TEST(SourceTest, UsesTheEntriesOfAList) {
  const Adder<> adder;
  EXPECT_THAT(adder.y.uses(), ElementsAre(&adder.weights, &adder.u[0], &adder.u[1]));
}

}  // namespace tenon::run_time_sizes_test
