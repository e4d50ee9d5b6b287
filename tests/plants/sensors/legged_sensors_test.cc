// The quadruped's sensors: encoders, torque and foot force.

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/sensors/force_sensors.h>
#include <tenon/plants/sensors/joint_encoders.h>
#include <tenon/plants/sensors/shank_forces.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/plants/sensors/error_statistics.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::legged_sensors_test {

using test::DogBot;
using test::RandomState;
using test::Standing;

constexpr int kSamples = 20000;

TEST(SensorErrorTest, WithoutNoiseDrawsNoNumbers) {
  RandomStream noise(1), untouched(1);
  SensorError error{.bias = 0.5};
  EXPECT_EQ(error.Measure(2.0, noise), 2.5);
  EXPECT_EQ(noise.Next(), untouched.Next());
  error.relative = 0.1;  // of a signal that happens to be 0
  EXPECT_EQ(error.Measure(0.0, noise), 0.5);
  EXPECT_NE(noise.Next(), untouched.Next());
}

TEST(JointEncodersTest, ErrorsHaveTheGivenMeanAndDeviation) {
  RandomStream random(1);
  const LeggedState x = RandomState(random);
  TestRig<JointEncoders> rig(
      JointEncodersParams{.angle = {.absolute = 1e-4, .bias = 0.001}, .speed = {.absolute = 0.02}});
  rig.Fix(rig->state, x);
  test::ErrorStatistics<12> angle, speed, product;
  for (int i = 0; i < kSamples; ++i) {
    const JointMotion& joints = rig.Tick()[rig->joints];
    angle.Add(joints.q - x.q);
    speed.Add(joints.qd - x.qd);
    product.Add((joints.q - x.q - Vec<12>::Constant(0.001)).cwiseProduct(joints.qd - x.qd));
  }
  angle.Expect(Vec<12>::Constant(0.001), Vec<12>::Constant(1e-4));
  speed.Expect(Vec<12>::Zero(), Vec<12>::Constant(0.02));
  // Angles and speeds have independent random streams.
  EXPECT_LT((product.sum / kSamples).cwiseAbs().maxCoeff(), 4 * 1e-4 * 0.02 / std::sqrt(kSamples));
}

TEST(JointEncodersTest, RoundToTheirResolution) {
  RandomStream random(2);
  const LeggedState x = RandomState(random);
  TestRig<JointEncoders> rig(JointEncodersParams{.bits = 9});
  rig.Fix(rig->state, x).Tick();
  constexpr double kResolution = 2 * std::numbers::pi / 512;
  for (int j = 0; j < kNumJoints; ++j) {
    EXPECT_NEAR(rig[rig->joints].q[j], x.q[j], kResolution / 2 + 1e-12) << j;
    EXPECT_NEAR(std::remainder(rig[rig->joints].q[j], kResolution), 0, 1e-12) << j;
  }
  EXPECT_EQ(rig[rig->joints].qd, x.qd);
}

TEST(JointEncodersTest, EachJointHasAConstantOffset) {
  const LeggedState x = Standing(DogBot());
  TestRig<JointEncoders> rig(JointEncodersParams{.offset_deviation = 0.01});
  rig.Fix(rig->state, x).Tick();
  const Vec<12> offset = rig[rig->joints].q - x.q;
  EXPECT_GT(offset.cwiseAbs().minCoeff(), 0);
  EXPECT_LT(offset.cwiseAbs().maxCoeff(), 0.04);
  EXPECT_NEAR(((rig.Tick()[rig->joints].q - x.q) - offset).norm(), 0, 1e-15) << "it stays";
}

/// At constant speed, filtered differences of the angles follow the step response of a first-order low-pass.
TEST(JointEncodersTest, SpeedsMayBeDifferencesOfAngles) {
  constexpr double kBandwidth = 50, kSpeed = 2;
  TestRig<JointEncoders> rig(JointEncodersParams{.speed_bandwidth = kBandwidth});
  LeggedState x = Standing(DogBot());
  rig.Fix(rig->state, x).Tick();
  EXPECT_EQ(rig[rig->joints].qd.norm(), 0) << "nothing to difference yet";
  for (int n = 1; n <= 20; ++n) {
    x.q.array() += 1e-3 * kSpeed;
    rig.Fix(rig->state, x).Tick();
    EXPECT_NEAR(rig[rig->joints].qd[7],
                kSpeed * (1 - std::exp(-2 * std::numbers::pi * kBandwidth * 1e-3 * n)), 1e-9)
        << n;
  }
}

TEST(FootForceSensorTest, SmallForcesAreAFootInTheAir) {
  TestRig<FootForceSensor> rig(FootForceSensorParams{.threshold = 10});
  FootForces forces;
  forces[kFrontLeft] = {3, 4, 8};   // 9.4 N
  forces[kRearRight] = {3, 4, 12};  // 13 N
  rig.Fix(rig->forces, forces).Tick();
  EXPECT_EQ(rig[rig->measured][kFrontLeft].norm(), 0);
  EXPECT_EQ(rig[rig->measured][kRearRight], forces[kRearRight]);
}

TEST(JointTorqueSensorTest, RelativeNoiseGrowsWithTheSignal) {
  Vec<12> torque = Vec<12>::LinSpaced(12, -40, 37);
  torque[5] = 0;
  TestRig<JointTorqueSensor> rig(TorqueSensorParams{.error = {.absolute = 0.5, .relative = 0.1, .bias = -1}});
  rig.Fix(rig->torque, torque);
  test::ErrorStatistics<12> error;
  for (int i = 0; i < kSamples; ++i) error.Add(rig.Tick()[rig->measured] - torque);
  error.Expect(Vec<12>::Constant(-1), Vec<12>(Vec<12>::Constant(0.5) + 0.1 * torque.cwiseAbs()));
}

TEST(FootForceSensorTest, EveryComponentHasItsOwnNoise) {
  FootForces forces;
  Vec<12> values = Vec<12>::LinSpaced(12, 10, 65);
  for (int leg = 0; leg < kNumLegs; ++leg) forces[leg] = values.segment<3>(3 * leg);
  TestRig<FootForceSensor> rig(FootForceSensorParams{.error = {.relative = 0.1}});
  rig.Fix(rig->forces, forces);
  test::ErrorStatistics<12> error;
  for (int i = 0; i < kSamples; ++i) {
    const FootForces& measured = rig.Tick()[rig->measured];
    Vec<12> all;
    for (int leg = 0; leg < kNumLegs; ++leg) all.segment<3>(3 * leg) = measured[leg] - forces[leg];
    error.Add(all);
  }
  error.Expect(Vec<12>::Zero(), 0.1 * values);
}

/// A force along the shank, from the knee to the foot, has in the shank's axes the direction that the
/// description says.
TEST(ShankForcesTest, AForceAlongTheShankIsAlongItInItsAxes) {
  RandomStream random(3);
  const QuadrupedDescription robot = test::DogBot();
  const LeggedState x = test::RandomState(random);
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(robot), x);
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg)
    forces[leg] = dynamics.feet[leg].p_W - dynamics.origin_W[kJointsPerLeg * leg + 2];
  TestRig<ShankForces> rig(ShankForcesParams{robot});
  rig.Fix(rig->state, x).Fix(rig->forces, forces);
  for (int leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(rig[rig->shank][leg], IsNear(robot.legs[leg].foot_J, 1e-12)) << leg;
}

}  // namespace tenon::legged_sensors_test
