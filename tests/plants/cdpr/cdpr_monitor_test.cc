#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cdpr_monitor_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Holds four cables, 800 N at most, with 100 N each, 2 m above the floor.
struct Rig : TestRig<CdprMonitor> {
  explicit Rig(const CdprMonitorParams& params = {.robot = test::FourCableRobot()}) : TestRig(params) {
    SetTension(100);
    SetPlatform(2);
  }
  void SetTension(double of_cable_2) {
    CableSignals cables = CableSignals::Zero(4);
    cables.tension.setConstant(100);
    cables.tension[2] = of_cable_2;
    Fix(system().cables, cables);
  }
  void SetPlatform(double height, double roll = 0) {
    PlatformState platform;
    platform.p_WB[2] = height;
    platform.q_WB = QuaternionFromRotationVector({roll, 0, 0});
    Fix(system().platform, platform);
  }
  RunStatus RunOn() { return simulator().AdvanceTo(context().time() + 0.5); }
};

TEST(CdprMonitorTest, EndsTheRunWhenACableIsSlack) {
  Rig rig;
  rig.SetTension(0.1);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(0);
  EXPECT_THAT(rig.RunOn().reason, HasSubstr("cable 2"));
}

TEST(CdprMonitorTest, ACableThatPullsNoHarderThanItsWeightIsSlack) {
  CdprMonitorParams params{.robot = test::FourCableRobot()};
  params.robot.cable.mass_per_length = 0.1;
  Rig rig(params);
  CableSignals cables = CableSignals::Zero(4);
  cables.rest_length.setConstant(5);
  cables.tension.setConstant(4.91);  // 0.1 kg/m of 5 m weigh 4.905 N
  rig.Fix(rig->cables, cables);
  EXPECT_FALSE(rig.RunOn().ended);
  cables.tension[1] = 4.9;
  rig.Fix(rig->cables, cables);
  EXPECT_THAT(rig.RunOn().reason, HasSubstr("cable 1"));
}

TEST(CdprMonitorTest, ACableHasALimitOfItsOwn) {
  CdprMonitorParams params{.robot = test::FourCableRobot()};
  params.robot.cables[2].tension_max = 300;
  Rig rig(params);
  rig.SetTension(329);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(331);
  EXPECT_THAT(rig.RunOn().reason, AllOf(HasSubstr("cable 2"), HasSubstr("330 N")));
}

TEST(CdprMonitorTest, SlackMayBeAllowed) {
  Rig rig;
  rig.SetTension(0);
  rig.Set(rig->forbid_slack, false);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.Set(rig->forbid_slack, true);
  EXPECT_TRUE(rig.RunOn().ended);
}

TEST(CdprMonitorTest, EndsTheRunWhenAWinchIsOverpowered) {
  Rig rig;
  rig.SetTension(879);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(881);
  EXPECT_THAT(rig.RunOn().reason, AllOf(HasSubstr("cable 2"), HasSubstr("881 N")));
}

// The platform's box is drawn with half edges of 0.075, 0.075 and 0.093 m.
TEST(CdprMonitorTest, EndsTheRunWhenTheBoxReachesBelowTheFloor) {
  Rig rig;
  rig.SetPlatform(0.094);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetPlatform(0.083);
  EXPECT_THAT(rig.RunOn().reason, AllOf(HasSubstr("block.place"), HasSubstr("0.01 m")));
  const double on_edge = (0.075 + 0.093) / std::sqrt(2);
  Rig tilted;
  tilted.SetPlatform(on_edge + 0.001, M_PI / 4);
  EXPECT_FALSE(tilted.RunOn().ended);
  tilted.SetPlatform(on_edge - 0.001, M_PI / 4);
  EXPECT_TRUE(tilted.RunOn().ended);
  CdprMonitorParams deep{.robot = test::FourCableRobot()};
  deep.robot.floor = -1;
  Rig low(deep);
  low.SetPlatform(-0.9);
  EXPECT_FALSE(low.RunOn().ended);
  low.SetPlatform(-0.92);
  EXPECT_THAT(low.RunOn().reason, HasSubstr("below the floor at -1 m"));
}

// The anchors are sqrt(3.5² + 4.5²) = 5.701 m from their middle, which is 4 m high.
TEST(CdprMonitorTest, EndsTheRunFarFromTheAnchors) {
  Rig rig;
  rig.SetPlatform(15.4);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetPlatform(1e30);
  EXPECT_THAT(rig.RunOn().reason, AllOf(HasSubstr("block.place"), HasSubstr("11.4 m")));
}

}  // namespace tenon::cdpr_monitor_test
