#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/controllers/cdpr/load_estimator.h>
#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::load_estimator_test {

const Vec<3> kGravity(0, 0, -9.81);

/// The sensor signals of a platform that turns about a horizontal axis while it moves up and down, with a
/// payload and an external wrench, from the laws of motion.
struct Motion {
  CdprDescription robot = test::WithSprings(test::EightCableRobot());
  Payload payload;
  PlatformWrench gust;

  PlatformEstimate estimate;
  ImuMeasurement inertial;
  CableSignals cables;

  void At(double t) {
    const double swing = 0.3 * std::sin(3 * t), rate = 0.9 * std::cos(3 * t), acceleration = -9 * swing;
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.4, 0).normalized();
    PlatformState& x = estimate.platform;
    x.p_WB = {0.1, -0.2, 1.8 + 0.05 * std::sin(2 * t)};
    x.q_WB = QuaternionFromRotationVector(swing * axis);
    const Eigen::Matrix3d R = x.R_WB();
    const Eigen::Vector3d w = rate * axis, alpha = acceleration * axis, a(0, 0, -0.2 * std::sin(2 * t));
    inertial.angular_velocity_B = R.transpose() * w;
    inertial.specific_force_B = R.transpose() * (a - kGravity);
    const Eigen::Vector3d arm = R * payload.p_B;
    const Eigen::Vector3d of_load =
        payload.mass * (kGravity - a - alpha.cross(arm) - w.cross(w.cross(arm)));  // on the platform
    const Eigen::Matrix3d I = R * robot.inertia_B * R.transpose();
    Vector6d pull;
    pull << robot.mass * (a - kGravity) - of_load - gust.force_W,
        I * alpha + w.cross(I * w) - arm.cross(of_load) - gust.torque_W;
    pull -= PassiveWrench(robot, x.p_WB, R) - GravityWrench(robot);
    // The tensions of least norm with this wrench; the estimator accepts negative ones.
    const CableKinematics lines = CalcCableKinematics(robot, x.p_WB, R);
    const Matrix6d gram = lines.structure * lines.structure.transpose();
    cables = CableSignals::Zero(robot.num_cables());
    cables.tension = lines.structure.transpose() * test::Solve(gram, pull);
  }
};

LoadEstimate After(Motion& motion, double seconds, LoadEstimatorParams params = {}) {
  params.robot = motion.robot;
  TestRig<LoadEstimator> rig(params);
  LoadEstimate load;
  for (int k = 0; k * params.rate.period() <= seconds; ++k) {
    motion.At(k * params.rate.period());
    rig.Fix(rig->estimate, motion.estimate).Fix(rig->inertial, motion.inertial);
    rig.Fix(rig->cables, motion.cables).Tick();
    load = rig[rig->load];
  }
  return load;
}

TEST(LoadEstimatorTest, IsZeroWithoutLoad) {
  Motion motion;
  const LoadEstimate load = After(motion, 2);
  EXPECT_EQ(load.payload.mass, 0);
  EXPECT_THAT(load.rest.force_W, IsNear(Vec<3>::Zero().eval(), 1e-6));
  EXPECT_THAT(load.rest.torque_W, IsNear(Vec<3>::Zero().eval(), 0.02));  // of Euler's step in the observer
}

// The position along the force becomes observable as the platform turns.
TEST(LoadEstimatorTest, FindsMassAndPlaceOfAPayload) {
  Motion motion;
  motion.payload = {5, {0.1, 0.6, -0.2}};
  const LoadEstimate load = After(motion, 10);
  EXPECT_NEAR(load.payload.mass, 5, 0.1);
  EXPECT_THAT(load.payload.p_B, IsNear(motion.payload.p_B, 0.03));
  EXPECT_LT(load.rest.force_W.norm(), 1);
  EXPECT_LT(load.rest.torque_W.norm(), 1);
}

TEST(LoadEstimatorTest, AGustIsNoPayload) {
  Motion motion;
  motion.gust = {{20, -10, 0}, {0, 0, 3}};
  const LoadEstimate load = After(motion, 5);
  EXPECT_EQ(load.payload.mass, 0);
  EXPECT_THAT(load.rest.force_W, IsNear(motion.gust.force_W, 0.05));
  EXPECT_THAT(load.rest.torque_W, IsNear(motion.gust.torque_W, 0.05));
}

// The known part has no lag, and the estimator finds the others.
TEST(LoadEstimatorTest, AddsAKnownWrench) {
  const PlatformWrench known{{5, 0, -30}, {1, -2, 0}};
  Motion motion;
  TestRig<LoadEstimator> rig(LoadEstimatorParams{.robot = motion.robot});
  rig.Fix(rig->known_wrench, known);
  const auto after = [&](int first, int last) {
    for (int k = first; k <= last; ++k) {
      motion.At(0.005 * k);
      rig.Fix(rig->estimate, motion.estimate).Fix(rig->inertial, motion.inertial);
      rig.Fix(rig->cables, motion.cables).Tick();
    }
    return rig[rig->load];
  };
  motion.gust = known;
  const LoadEstimate first = after(0, 0);
  EXPECT_THAT(first.rest.force_W, IsNear(known.force_W, 1e-9));
  EXPECT_THAT(first.rest.torque_W, IsNear(known.torque_W, 1e-9));
  motion.gust.force_W += Vec<3>(0, 20, 0);
  const LoadEstimate later = after(1, 1000);
  EXPECT_EQ(later.payload.mass, 0);
  EXPECT_THAT(later.rest.force_W, IsNear(motion.gust.force_W, 0.05));
  EXPECT_THAT(later.rest.torque_W, IsNear(motion.gust.torque_W, 0.05));
}

// The integrated error of two low-pass filters in series after a step is the sum of their time constants.
TEST(LoadEstimatorTest, FollowsAStepWithItsTimeConstants) {
  Motion motion;
  TestRig<LoadEstimator> rig({.robot = motion.robot, .bandwidth = 5, .rest_bandwidth = 10});
  motion.At(0);
  double lack = 0, last = 0;  // [N s], [N]
  for (int k = 0; k <= 600; ++k) {
    motion.gust.force_W = {k > 0 ? 10.0 : 0.0, 0, 0};
    motion.At(0);
    motion.inertial.angular_velocity_B.setZero();
    rig.Fix(rig->estimate, motion.estimate).Fix(rig->inertial, motion.inertial);
    rig.Fix(rig->cables, motion.cables).Tick();
    const double now = rig[rig->load].rest.force_W[0];
    EXPECT_GE(now, last - 1e-12);
    last = now;
    lack += 0.005 * (motion.gust.force_W[0] - now);
  }
  EXPECT_NEAR(last, 10, 1e-4);
  EXPECT_NEAR(lack, 10 * (1 / 5.0 + 1 / 10.0), 10 * 0.005);
}

TEST(LoadEstimatorTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<LoadEstimator>({.robot = test::EightCableRobot(), .bandwidth = 300}, "bandwidth"));
}

// One body has the energy, momentum and angular momentum of platform and payload at any velocity.
TEST(LoadedPlatformTest, MovesAsItsParts) {
  const CdprDescription robot = test::EightCableRobot();
  const Payload payload{4, {0.2, -0.5, 0.3}};
  const LoadedPlatform body(robot, payload);
  const Eigen::Vector3d v(0.3, -0.2, 0.5), w(1, 2, -0.7);
  const Eigen::Vector3d v_load = v + w.cross(payload.p_B), v_com = v + w.cross(body.com_B);
  EXPECT_THAT((body.mass * v_com).eval(), IsNear((robot.mass * v + payload.mass * v_load).eval(), 1e-12));
  EXPECT_NEAR(body.mass * v_com.squaredNorm() + w.dot(body.inertia * w),
              robot.mass * v.squaredNorm() + w.dot(robot.inertia_B * w) + payload.mass * v_load.squaredNorm(),
              1e-12);
}

CableVector Of(double a, double b, double c, double d) {
  return Eigen::Vector4d(a, b, c, d);
}

class BrokenCableDetectorTest : public ::testing::Test {
 protected:
  /// The broken cables that are found after `ticks` ticks of 1 ms with these tensions and commands.
  CableVector After(const CableVector& tension, const CableVector& command, int ticks) {
    CableSignals cables = CableSignals::Zero(4);
    cables.tension = tension;
    cables.length = cables.rest_length = CableVector::Constant(4, 5);
    cables.rest_length[0] += slack;
    cables.length_rate[0] = rate;
    rig.Fix(rig->cables, cables).Fix(rig->command, command);
    for (int k = 0; k < ticks; ++k) rig.Tick();
    return rig[rig->broken];
  }
  double slack = 0, rate = 0;  // of the first cable [m], [m/s]
  TestRig<BrokenCableDetector> rig{BrokenCableDetectorParams{.num_cables = 4}};
  const CableVector commands = Of(100, 100, 100, 10);
};

TEST_F(BrokenCableDetectorTest, TakesItsTimeAndNeverForgets) {
  EXPECT_EQ(After(Of(90, 0, 110, 0), commands, 50), Of(0, 0, 0, 0));
  EXPECT_EQ(After(Of(90, 0, 110, 0), commands, 2), Of(0, 1, 0, 0))
      << "the last command is too small to decide";
  EXPECT_EQ(After(Of(90, 100, 110, 10), commands, 100), Of(0, 1, 0, 0));
}

TEST_F(BrokenCableDetectorTest, ACableThatIsSlackForAMomentIsNotBroken) {
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(After(Of(90, 0, 110, 10), commands, 45), Of(0, 0, 0, 0));
    EXPECT_EQ(After(Of(90, 21, 110, 10), commands, 2), Of(0, 0, 0, 0)) << "more than a fifth";
  }
}

TEST_F(BrokenCableDetectorTest, ACableShorterThanItsRestLengthIsSlack) {
  slack = 0.01;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  slack = 0;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(1, 0, 0, 0));
}

// A winch of 90 N s/m that reels in at 1 m/s leaves 10 N of 100 N; at 0.5 m/s, 55 N.
TEST_F(BrokenCableDetectorTest, ACableThatIsReeledInQuicklyPullsLess) {
  rate = -1;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  rate = -0.5;
  EXPECT_EQ(After(Of(12, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  EXPECT_EQ(After(Of(10, 90, 110, 10), commands, 100), Of(1, 0, 0, 0));
}

TEST_F(BrokenCableDetectorTest, IfNoCablePullsTheSensorsHaveFailed) {
  EXPECT_EQ(After(Of(0, 0, 0, 0), commands, 200), Of(0, 0, 0, 0));
}

}  // namespace tenon::load_estimator_test
