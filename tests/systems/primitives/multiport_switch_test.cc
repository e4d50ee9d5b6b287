#include <tenon/systems/primitives/multiport_switch.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::multiport_switch_test {

enum class Gait { kStand, kTrot, kPace };

TEST(MultiportSwitchTest, SelectsByNumber) {
  TestRig<MultiportSwitch<Vec<2>>> rig({.count = 3, .unit = "m", .elements = "x, z"});
  for (int i = 0; i < 3; ++i) rig.Fix(rig->u[static_cast<std::size_t>(i)], {i, -i});
  for (int i = 0; i < 3; ++i) EXPECT_THAT(rig.Fix(rig->select, i)[rig->y], IsNear(Vec<2>(i, -i), 0));
  EXPECT_EQ(rig->u[2].path(), "block.u_2");
  EXPECT_EQ(rig->u[2].elements()[1].name, "z");
}

TEST(MultiportSwitchTest, SelectsByEnumeration) {
  TestRig<MultiportSwitch<std::string, Gait>> rig({.count = 3});
  rig.Fix(rig->u[0], "stand").Fix(rig->u[1], "trot").Fix(rig->u[2], "pace");
  EXPECT_EQ(rig.Fix(rig->select, Gait::kPace)[rig->y], "pace");
}

TEST(MultiportSwitchTest, RefusesNumbersOfNoSignal) {
  TestRig<MultiportSwitch<>> rig({.count = 2});
  rig.Fix(rig->u[0], 1).Fix(rig->u[1], 2);
  for (const int bad : {-1, 2}) {
    rig.Fix(rig->select, bad);
    EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'", "select is " + std::to_string(bad)));
  }
}

TEST(MultiportSwitchTest, RefusesToChooseFromNothing) {
  EXPECT_TRUE(Refuses<MultiportSwitch<>>({.count = 0}, "count"));
}

}  // namespace tenon::multiport_switch_test
