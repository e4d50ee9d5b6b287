// Values that several calculations and several blocks share.

#include <tenon/systems/primitives/adder.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::shared_test {

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

}  // namespace tenon::shared_test
