// Properties of ports and states that tools read.

#include <tenon/systems/primitives/adder.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::source_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

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

}  // namespace tenon::source_test
