// The quadruped's sensors: encoders, torque and foot force.

#include <tenon/plants/sensors/force_sensors.h>
#include <tenon/plants/sensors/joint_encoders.h>
#include <tenon/plants/sensors/shank_forces.h>
#include <tenon/plants/sensors/terrain_mapper.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/plants/sensors/error_statistics.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::legged_sensors_test {

using test::DogBot, test::RandomState, test::Standing;

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

TerrainMapperParams Params(double noise) {
  return {.terrain = {.stairs = Stairs{.rise = 0.1, .steps = 1}}, .map = {.noise = noise}};
}

ElevationMap MapOf(const TerrainMapperParams& params, const LeggedState& state, const LeggedState& told) {
  TestRig<TerrainMapper> rig(params);
  rig.Fix(rig->state, state).Fix(rig->told, told).Tick();
  return rig[rig->map];
}

TEST(TerrainMapperTest, ShowsTheKerbWhereItIs) {
  const LeggedState state{.p_WB = {0.9, 0.2, 0.5}};
  const ElevationMap map = MapOf(Params(0), state, state);
  EXPECT_EQ(map.HeightAt({0.97, 0}), 0);
  EXPECT_NEAR(map.HeightAt({1.03, 0}), 0.1, 1e-12);
  EXPECT_NEAR(map.HeightAt({1.7, -0.6}), 0.1, 1e-12);
}

// A robot that believes to be further ahead, higher and turned sees the kerb in its own axes.
TEST(TerrainMapperTest, MovesWithTheErrorOfTheState) {
  LeggedState state, told;
  state.p_WB << 0.9, 0, 0.5;
  told.p_WB << 1.4, 0.3, 0.7;
  told.q_WB = QuaternionFromRotationVector({0, 0, M_PI / 2});
  const ElevationMap map = MapOf(Params(0), state, told);  // ahead is now y
  EXPECT_NEAR(map.HeightAt({1.4, 0.3 + 0.05}), 0.2, 1e-12);
  EXPECT_NEAR(map.HeightAt({1.4, 0.3 + 0.15}), 0.3, 1e-12);
}

TEST(TerrainMapperTest, NoiseBelongsToThePlace) {
  LeggedState state{.p_WB = {-5, 3, 0.5}};
  const ElevationMap before = MapOf(Params(0.01), state, state);
  state.p_WB[0] += 0.3;
  const ElevationMap after = MapOf(Params(0.01), state, state);
  double squares = 0;
  for (const double h : before.height) squares += h * h;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(before.height.size())), 0.01, 5e-4);
  for (const double x : {-5.2, -5.0, -4.5})
    EXPECT_EQ(before.HeightAt({x, 3.1}), after.HeightAt({x, 3.1})) << x;
  TerrainMapperParams other = Params(0.01);
  other.seed = 2;
  EXPECT_NE(MapOf(other, state, state).HeightAt({-5, 3}), after.HeightAt({-5, 3}));
}

}  // namespace tenon::legged_sensors_test
