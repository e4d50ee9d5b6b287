#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::constant_test {

TEST(ConstantSourceTest, GivesItsValue) {
  TestRig<ConstantSource<Vec<2>>> rig({.value = {1, 2}, .unit = "N"});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.RunTo(10)[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_EQ(rig->y.elements()[0].unit, "N");
}

TEST(ConstantSourceTest, GivesVectorsOfAnySize) {
  TestRig<ConstantSource<std::vector<double>>> rig({.value = {1, 2, 3}});
  EXPECT_EQ(rig[rig->y], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(rig->y.elements().size(), 3u);
}

TEST(ConstantSourceTest, IsSetInARun) {
  TestRig<ConstantSource<>> rig({.value = 1});
  rig.RunTo(1).Set(rig->value, 5);
  EXPECT_EQ(rig.RunTo(2)[rig->y], 5);
}

}  // namespace tenon::constant_test
