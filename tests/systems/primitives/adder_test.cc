#include <tenon/systems/primitives/adder.h>
#include <tenon/tests/testing/block_test.h>

#include <vector>

namespace tenon::adder_test {

TEST(AdderTest, Weighs) {
  TestRig<Adder<Vec<2>>> rig({.weights = {1, -1, 0.5}});
  auto& u = rig->u;
  rig.Fix(u[0], {1, 2}).Fix(u[1], {3, 5}).Fix(u[2], {4, -4});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(0, -5), 0));
}

TEST(AdderTest, TakesManyInputs) {
  const std::vector<double> weights = {1, 2, 3, 4, 5};
  TestRig<Adder<>> rig({.weights = weights});
  for (std::size_t i = 0; i < weights.size(); ++i) rig.Fix(rig->u[i], 1);
  EXPECT_EQ(rig[rig->y], 15);
  rig.Set(rig->weights, {1, 1, 1, 1, 0});
  EXPECT_EQ(rig[rig->y], 4);
  EXPECT_EQ(rig.context().Clone()->EvalDoubles(rig->weights), (std::vector<double>{1, 1, 1, 1, 0}));
}

TEST(AdderTest, WeightsAreSaved) {
  TestRig<Adder<>> two, one;
  two.Set(two->weights, {3, -1});
  one.Set(one->weights, {5});
  one.context().Restore(two.context().Save());
  EXPECT_EQ(one[one->weights], (std::vector<double>{3, -1}));
}

TEST(AdderTest, RefusesBadWeights) {
  EXPECT_TRUE(Refuses<Adder<>>({.weights = {}}, "weights"));
  EXPECT_TRUE(Refuses<Adder<>>({.weights = {1, test::kInfinity}}, "weights"));
}

TEST(AdderTest, WeightsAreSetInARun) {
  TestRig<Adder<>> rig;
  rig.Fix(rig->u[0], 3).Fix(rig->u[1], 4).Set(rig->weights, {1, -1});
  EXPECT_EQ(rig[rig->y], -1);
  rig.Set(rig->weights, {1});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'"));
}

}  // namespace tenon::adder_test
