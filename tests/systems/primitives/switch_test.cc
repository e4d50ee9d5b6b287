#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/switch.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::switch_test {
namespace {

TEST(SwitchTest, Selects) {
  TestRig<Switch<Vec<2>>> rig;
  auto& block = rig.system();
  rig.Fix(block.on, {1, 2}).Fix(block.off, {3, 4});
  EXPECT_THAT(rig.Fix(block.select, true)[block.y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Fix(block.select, false)[block.y], IsNear(Vec<2>(3, 4), 0));
}

TEST(ThresholdSwitchTest, ComparesWithItsThreshold) {
  TestRig<ThresholdSwitch<>> rig(ThresholdSwitchParams{.threshold = 0.5});
  auto& block = rig.system();
  rig.Fix(block.on, 1).Fix(block.off, -1);
  EXPECT_EQ(rig.Fix(block.control, 0.4)[block.y], -1);
  EXPECT_EQ(rig.Fix(block.control, 0.5)[block.y], 1);
  EXPECT_EQ(rig.Fix(block.control, 0.6)[block.y], 1);
}

TEST(ThresholdSwitchTest, CarriesAnything) {
  TestRig<ThresholdSwitch<std::string>> rig;
  auto& block = rig.system();
  EXPECT_EQ(rig.Fix(block.on, "stance").Fix(block.off, "swing").Fix(block.control, -1)[block.y], "swing");
}

TEST(ThresholdSwitchTest, RefusesAThresholdThatIsNotFinite) {
  EXPECT_TRUE(Throws<ParameterError>(
      [] { ThresholdSwitch<> block(ThresholdSwitchParams{.threshold = std::nan("")}); }, "threshold",
      "finite"));
}

TEST(ThresholdSwitchTest, TheThresholdIsSetInARun) {
  TestRig<ThresholdSwitch<>> rig({.threshold = 0.5});
  rig.Fix(rig->on, 1).Fix(rig->off, -1).Fix(rig->control, 0.7).Set(rig->threshold, 0.8);
  EXPECT_EQ(rig[rig->y], -1);
}

}  // namespace
}  // namespace tenon::switch_test
