#include <tenon/plants/legged/fall_monitor.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::fall_monitor_test {

using ::testing::AllOf, ::testing::HasSubstr;

LeggedState At(const Vec<3>& p_WB, double roll = 0) {
  LeggedState x;
  x.p_WB = p_WB;
  x.q_WB = QuaternionFromRotationVector({roll, 0, 0});
  return x;
}

TEST(FallMonitorTest, EndsTheRunWhenTheTrunkIsLow) {
  TestRig<FallMonitor> rig(FallMonitorParams{.min_height = 0.2});
  rig.Fix(rig->state, At({0, 0, 0.201}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 0.1999999}));
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  // Rounded numbers may be equal, so the message does not compare them.
  EXPECT_THAT(status.reason,
              AllOf(HasSubstr("block.fall"), HasSubstr("is 0.200 m above the ground; the limit is 0.200 m")));
}

TEST(FallMonitorTest, HeightCountsFromTheGroundBelow) {
  FallMonitorParams params{.min_height = 0.2};
  params.terrain.grade = {0.5, 0};
  TestRig<FallMonitor> rig(params);
  rig.Fix(rig->state, At({-2, 0, -0.79}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({2, 0, 1.19}));
  EXPECT_TRUE(rig.simulator().AdvanceTo(1).ended);
}

TEST(FallMonitorTest, EndsTheRunWhenTheTrunkTilts) {
  TestRig<FallMonitor> rig(FallMonitorParams{.max_tilt = 0.8});
  rig.Fix(rig->state, At({0, 0, 1}, -0.79));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 1}, -0.81));
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  EXPECT_THAT(status.reason, AllOf(HasSubstr("block.fall"), HasSubstr("0.810 rad"), HasSubstr("0.800 rad")));
}

TEST(FallMonitorTest, EndsTheRunWhenTheRobotFlies) {
  TestRig<FallMonitor> rig;
  rig.Fix(rig->state, At({0, 0, 9.9}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 21e3}));
  EXPECT_THAT(rig.simulator().AdvanceTo(1).reason, AllOf(HasSubstr("block.flight"), HasSubstr("10.000 m")));
}

TEST(FallMonitorTest, RefusesLimitsThatMakeNoSense) {
  EXPECT_TRUE(Refuses<FallMonitor>({.min_height = 1, .max_height = 1}, "max_height"));
}

TEST(FallMonitorTest, LimitsAreSetInARun) {
  TestRig<FallMonitor> rig(FallMonitorParams{.min_height = 0.2, .max_tilt = 0.8});
  rig.Fix(rig->state, At({0, 0, 0.15}, 0.9)).Set(rig->min_height, 0.1).Set(rig->max_tilt, 1);
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Set(rig->max_tilt, 0.85);
  EXPECT_THAT(rig.simulator().AdvanceTo(1).reason, AllOf(HasSubstr("0.900 rad"), HasSubstr("0.850 rad")));
}

}  // namespace tenon::fall_monitor_test
