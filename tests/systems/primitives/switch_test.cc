#include <tenon/systems/primitives/switch.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::switch_test {

TEST(SwitchTest, Selects) {
  TestRig<Switch<Vec<2>>> rig;
  rig.Fix(rig->on, {1, 2}).Fix(rig->off, {3, 4});
  EXPECT_THAT(rig.Fix(rig->select, true)[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Fix(rig->select, false)[rig->y], IsNear(Vec<2>(3, 4), 0));
}

TEST(ThresholdSwitchTest, ComparesWithItsThreshold) {
  TestRig<ThresholdSwitch<>> rig({.threshold = 0.5});
  rig.Fix(rig->on, 1).Fix(rig->off, -1);
  EXPECT_EQ(rig.Fix(rig->control, 0.4)[rig->y], -1);
  EXPECT_EQ(rig.Fix(rig->control, 0.5)[rig->y], 1);
  EXPECT_EQ(rig.Fix(rig->control, 0.6)[rig->y], 1);
}

TEST(ThresholdSwitchTest, RefusesAThresholdThatIsNotFinite) {
  EXPECT_TRUE(Refuses<ThresholdSwitch<>>({.threshold = test::kNan}, "threshold"));
}

TEST(ThresholdSwitchTest, TheThresholdIsSetInARun) {
  TestRig<ThresholdSwitch<>> rig({.threshold = 0.5});
  rig.Fix(rig->on, 1).Fix(rig->off, -1).Fix(rig->control, 0.7).Set(rig->threshold, 0.8);
  EXPECT_EQ(rig[rig->y], -1);
}

}  // namespace tenon::switch_test
