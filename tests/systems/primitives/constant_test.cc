#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::constant_test {
namespace {

TEST(ConstantSourceTest, GivesItsValue) {
  TestRig<ConstantSource<Vec<2>>> rig(ConstantParams<Vec<2>>{.value = {1, 2}, .unit = "N"});
  EXPECT_THAT(rig[rig.system().y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.RunTo(10)[rig.system().y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_EQ(rig.system().y.elements()[0].unit, "N");
}

TEST(ConstantSourceTest, GivesVectorsOfAnySize) {
  TestRig<ConstantSource<std::vector<double>>> rig(ConstantParams<std::vector<double>>{.value = {1, 2, 3}});
  EXPECT_EQ(rig[rig.system().y], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(rig.system().y.elements().size(), 3u);
}

TEST(ConstantSourceTest, IsZeroByDefault) {
  TestRig<ConstantSource<>> rig;
  EXPECT_EQ(rig[rig.system().y], 0);
}

TEST(ConstantSourceTest, IsSetInARun) {
  TestRig<ConstantSource<>> rig(ConstantParams<>{.value = 1});
  rig.RunTo(1).Set(rig->value, 5);
  EXPECT_EQ(rig.RunTo(2)[rig->y], 5);
}

}  // namespace
}  // namespace tenon::constant_test
