#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/sensors/error_statistics.h>
#include <tenon/tests/testing/block_test.h>

#include <vector>

namespace tenon::pose_sensor_test {

using Rig = TestRig<PoseSensor>;

PlatformState Somewhere() {
  return {{0.5, -1, 2},
          QuaternionFromRotation(RotationFromEuler({0.3, -0.2, 1})),
          Vec<3>::Zero(),
          Vec<3>::Zero()};
}

/// The rotation vector of a small rotation, to second order of its angle.
Vec<3> SmallRotation(const Eigen::Matrix3d& R) {
  return Vec<3>(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1)) / 2;
}

TEST(PoseSensorTest, WithoutNoisePassesTheTruth) {
  Rig rig(PoseSensorParams{.position_noise = {0, 0, 0}, .attitude_noise = {0, 0, 0}});
  rig.Fix(rig->platform, Somewhere()).Tick();
  EXPECT_EQ(rig[rig->pose].p_WB, Somewhere().p_WB);
  EXPECT_THAT(rig[rig->pose].q_WB, IsNear(Somewhere().q_WB, 1e-15));
}

// The offsets that a calibration leaves are constant during a run.
TEST(PoseSensorTest, OffsetsStay) {
  const PoseSensorParams params{.position_noise = {0, 0, 0},
                                .attitude_noise = {0, 0, 0},
                                .position_offset = 0.1,
                                .attitude_offset = 0.05};
  Rig rig(params);
  rig.Fix(rig->platform, Somewhere()).Tick();
  const PoseMeasurement first = rig[rig->pose];
  EXPECT_GT((first.p_WB - Somewhere().p_WB).norm(), 0.02);
  const Vec<3> turn = SmallRotation(Somewhere().R_WB().transpose() * first.R_WB());
  EXPECT_GT(turn.norm(), 0.01);
  PlatformState other = Somewhere();
  other.p_WB += Vec<3>(1, 2, 3);
  other.q_WB = {1, 0, 0, 0};
  rig.Fix(rig->platform, other).Tick();
  const PoseMeasurement second = rig[rig->pose];
  EXPECT_THAT(Vec<3>(second.p_WB - other.p_WB), IsNear(Vec<3>(first.p_WB - Somewhere().p_WB), 1e-12));
  EXPECT_THAT(SmallRotation(second.R_WB()), IsNear(turn, 1e-12)) << "about the platform's axes";
}

TEST(PoseSensorTest, NoiseHasTheGivenDeviationsAndNoMean) {
  const PoseSensorParams params{.position_noise = {0.005, 0.001, 0.02},
                                .attitude_noise = {0.01, 0.02, 0.005}};
  Rig rig(params);
  rig.Fix(rig->platform, Somewhere());
  test::ErrorStatistics<6> statistics;
  for (int i = 0; i < 20000; ++i) {
    const PoseMeasurement& pose = rig.Tick()[rig->pose];
    ASSERT_NEAR(pose.q_WB.norm(), 1, 1e-12);
    Vec<6> error;
    error << pose.p_WB - Somewhere().p_WB, SmallRotation(Somewhere().R_WB().transpose() * pose.R_WB());
    statistics.Add(error);
  }
  Vec<6> deviation;
  deviation << params.position_noise, params.attitude_noise;
  statistics.Expect(Vec<6>::Zero(), deviation);
}

TEST(PoseSensorTest, SamplesAtItsRateAndHoldsBetween) {
  Rig rig;
  rig.Fix(rig->platform, Somewhere()).Tick();
  EXPECT_DOUBLE_EQ(rig.simulator().next_tick_time(), 1.0 / 200);
  const PoseMeasurement held = rig[rig->pose];
  rig.RunTo(0.0049);
  EXPECT_EQ(rig[rig->pose].p_WB, held.p_WB);
  rig.RunTo(0.005);
  EXPECT_NE(rig[rig->pose].p_WB, held.p_WB);
}

}  // namespace tenon::pose_sensor_test
