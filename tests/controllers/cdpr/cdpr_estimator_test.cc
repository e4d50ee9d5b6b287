#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <random>

namespace tenon::cdpr_estimator_test {

/// A sway at 2 Hz in closed form.
struct Motion {
  PlatformState platform;
  Vec<3> a_W;
};
Motion At(double t) {
  const double w = 4 * M_PI, r = 0.05, tilt = 0.1;
  return {.platform = {.p_WB = {r * (1 - std::cos(w * t)), 0.3, 2},
                       .q_WB = QuaternionFromRotationVector({0, tilt * (1 - std::cos(w * t)), 0}),
                       .v_W = {r * w * std::sin(w * t), 0, 0},
                       .w_W = {0, tilt * w * std::sin(w * t), 0}},
          .a_W = {r * w * w * std::cos(w * t), 0, 0}};
}

PoseMeasurement Pose(const Motion& motion) {
  return {motion.platform.p_WB, motion.platform.q_WB};
}
ImuMeasurement Inertial(const Motion& motion) {
  const Eigen::Matrix3d R_BW = motion.platform.R_WB().transpose();
  return {R_BW * motion.platform.w_W, R_BW * (motion.a_W + Vec<3>(0, 0, 9.81))};
}

double TurnBetween(const PlatformState& a, const PlatformState& b) {
  return std::acos(std::min(1.0, std::abs(a.q_WB.normalized().dot(b.q_WB.normalized())))) * 2;
}

TEST(CdprEstimator, StartsAtThePoseMeasured) {
  TestRig<CdprEstimator> rig;
  const Motion motion = At(0.1);
  rig.Fix(rig->pose, Pose(motion)).Fix(rig->inertial, Inertial(motion)).Tick();
  const PlatformEstimate& estimate = rig[rig->estimate];
  EXPECT_EQ(estimate.time, 0);
  EXPECT_THAT(estimate.platform.p_WB, IsNear(motion.platform.p_WB, 0));
  EXPECT_THAT(estimate.platform.v_W, IsNear(Vec<3>::Zero(), 0));
  EXPECT_THAT(estimate.platform.w_W, IsNear(motion.platform.w_W, 1e-14));
}

TEST(CdprEstimator, FollowsPerfectSensors) {
  TestRig<CdprEstimator> rig(CdprEstimatorParams{
      .noise = {.position = 1e-4, .attitude = 1e-4, .angular_velocity = 1e-3, .specific_force = 0.1}});
  for (int k = 0; k <= 400; ++k) {
    const Motion motion = At(0.005 * k);
    rig.Fix(rig->pose, Pose(motion)).Fix(rig->inertial, Inertial(motion)).Tick();
    if (k < 100) continue;
    const PlatformEstimate& estimate = rig[rig->estimate];
    ASSERT_NEAR(estimate.time, 0.005 * k, 1e-12);
    ASSERT_LT((estimate.platform.p_WB - motion.platform.p_WB).norm(), 1e-4) << k;
    ASSERT_LT((estimate.platform.v_W - motion.platform.v_W).norm(), 2e-3) << k;
    ASSERT_LT(TurnBetween(estimate.platform, motion.platform), 5e-4) << k;
  }
}

// q and -q are the same attitude.
TEST(CdprEstimator, IgnoresTheSignOfTheQuaternion) {
  TestRig<CdprEstimator> plain, flipped;
  for (int k = 0; k < 50; ++k) {
    const Motion motion = At(0.005 * k);
    PoseMeasurement pose = Pose(motion);
    pose.q_WB = QuaternionProduct(pose.q_WB, QuaternionFromRotationVector({0.01, 0.02 * (k % 3), -0.01}));
    plain.Fix(plain->pose, pose).Fix(plain->inertial, Inertial(motion)).Tick();
    if (k % 2 == 1) pose.q_WB = -pose.q_WB;
    flipped.Fix(flipped->pose, pose).Fix(flipped->inertial, Inertial(motion)).Tick();
    EXPECT_THAT(flipped[flipped->estimate].platform.R_WB(),
                IsNear(plain[plain->estimate].platform.R_WB(), 1e-14));
    EXPECT_THAT(flipped[flipped->estimate].platform.v_W, IsNear(plain[plain->estimate].platform.v_W, 1e-14));
  }
}

CableSignals Lengths(const CdprDescription& robot, const PlatformState& platform) {
  CableSignals cables = CableSignals::Zero(robot.num_cables());
  cables.length = CalcCableKinematics(robot, platform.p_WB, platform.R_WB()).length;
  return cables;
}

/// Deviations of position [m], velocity [m/s] and attitude [rad], after the first two of 20 s.
struct Deviations {
  double p = 0, v = 0, turn = 0;
  double believed_p = 0;  // from the covariance in the end
};
/// The deviations with the default noise; `told` maps the true cable signals to the measured ones.
template <class Told>
Deviations FlyWithNoise(const CdprDescription& robot, const Told& told) {
  TestRig<CdprEstimator> rig(CdprEstimatorParams{.robot = robot});
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const auto noise = [&](double deviation) {
    return Vec<3>(deviation * normal(generator), deviation * normal(generator),
                  deviation * normal(generator));
  };
  Deviations sum;
  int count = 0;
  for (int k = 0; k <= 4000; ++k) {
    const Motion motion = At(0.005 * k);
    PoseMeasurement pose = Pose(motion);
    pose.p_WB += noise(0.005);
    pose.q_WB = QuaternionProduct(pose.q_WB, QuaternionFromRotationVector(noise(0.01)));
    ImuMeasurement inertial = Inertial(motion);
    inertial.angular_velocity_B += noise(0.005);
    inertial.specific_force_B += noise(0.05);
    if (robot.num_cables() > 0) rig.Fix(rig->cables, told(k, Lengths(robot, motion.platform)));
    rig.Fix(rig->pose, pose).Fix(rig->inertial, inertial).Tick();
    if (k < 400) continue;
    const PlatformState& platform = rig[rig->estimate].platform;
    sum.p += (platform.p_WB - motion.platform.p_WB).squaredNorm();
    sum.v += (platform.v_W - motion.platform.v_W).squaredNorm();
    sum.turn += std::pow(TurnBetween(platform, motion.platform), 2);
    ++count;
  }
  return {std::sqrt(sum.p / count), std::sqrt(sum.v / count), std::sqrt(sum.turn / count),
          std::sqrt(rig[rig->memory].covariance.diagonal().template head<3>().sum())};
}
CableSignals Unchanged(int, const CableSignals& cables) {
  return cables;
}

// The pose alone has 5 mm per axis; differences of it over 5 ms would have 1.4 m/s.
TEST(CdprEstimator, FiltersNoise) {
  const Deviations found = FlyWithNoise({}, Unchanged);
  EXPECT_LT(found.p, 0.002);
  EXPECT_LT(found.v, 0.01);
  EXPECT_LT(found.turn, 0.003);
  // The covariance of the filter has the same size.
  EXPECT_NEAR(found.believed_p, found.p, 0.001);
}

TEST(CdprEstimator, LengthsImproveTheVelocity) {
  const Deviations without = FlyWithNoise({}, Unchanged);
  for (const int cables : {4, 8, 12}) {
    const Deviations with = FlyWithNoise(test::RobotWithCables(cables), Unchanged);
    EXPECT_LT(with.p, 0.6 * without.p) << cables;
    EXPECT_LT(with.v, 0.6 * without.v) << cables;
    EXPECT_LT(with.turn, 1.05 * without.turn) << cables;
  }
}

// A drum that changes layers scales the length by 1.1, and one that slips loses 1 cm every 1.5 s. The other
// lengths still improve the estimate.
TEST(CdprEstimator, ALengthThatIsWrongLosesItsWeight) {
  const CdprDescription robot = test::FourCableRobot();
  const double without = FlyWithNoise({}, Unchanged).p;
  const CableSignals start = Lengths(robot, At(0).platform);
  const auto layers = [&](int, CableSignals cables) {
    cables.length[0] += 0.1 * (cables.length[0] - start.length[0]);
    return cables;
  };
  const auto slip = [](int k, CableSignals cables) {
    cables.length[2] -= 0.01 * (k / 300);
    return cables;
  };
  EXPECT_LT(FlyWithNoise(robot, layers).p, 0.9 * without);
  EXPECT_LT(FlyWithNoise(robot, slip).p, 0.9 * without);
}

}  // namespace tenon::cdpr_estimator_test
