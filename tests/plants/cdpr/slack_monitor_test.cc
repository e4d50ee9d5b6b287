#include <tenon/plants/cdpr/slack_monitor.h>

#include <gmock/gmock.h>

#include <tenon/tests/testing/test_rig.h>

namespace tenon {
namespace {

CableSignals WithTension(double tension_of_cable_2) {
  CableSignals cables = CableSignals::Zero(4);
  cables.tension.setConstant(100);
  cables.tension[2] = tension_of_cable_2;
  return cables;
}

TEST(SlackMonitorTest, EndsTheRunWhenACableIsSlack) {
  TestRig<SlackMonitor> rig;
  rig.Fix(rig.system().cables, WithTension(0.1));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig.system().cables, WithTension(0));
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  EXPECT_EQ(status.reason, "block.slack: cable 2 is slack");
}

TEST(SlackMonitorTest, CanBeSwitchedOff) {
  TestRig<SlackMonitor> rig(SlackMonitorParams{.forbid_slack = false});
  rig.Fix(rig.system().cables, WithTension(0));
  EXPECT_FALSE(rig.simulator().AdvanceTo(1).ended);
}

TEST(SlackMonitorTest, IsSwitchedInARun) {
  TestRig<SlackMonitor> rig;
  rig.Fix(rig->cables, WithTension(0)).Set(rig->forbid_slack, false);
  EXPECT_FALSE(rig.simulator().AdvanceTo(1).ended);
  rig.Set(rig->forbid_slack, true);
  EXPECT_TRUE(rig.simulator().AdvanceTo(2).ended);
}

}  // namespace
}  // namespace tenon
