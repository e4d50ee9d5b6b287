#include <tenon/plants/sensors/cable_sensors.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/sensors/error_statistics.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::imu_test {

using Rig = TestRig<Imu>;
using PoseRig = TestRig<PoseSensor>;

ImuParams Noiseless() {
  return {.angular_velocity_noise = Vec<3>::Zero(), .specific_force_noise = Vec<3>::Zero()};
}

PlatformState Tilted() {
  return {
      {0, 0, 0}, QuaternionFromRotation(RotationFromEuler({0.3, -0.2, 1})), Vec<3>::Zero(), {0.4, 0.5, -0.6}};
}

// At rest, in free fall, and in motion.
TEST(ImuTest, ReadsSpecificForceAndRateInTheBodysAxes) {
  for (const Vec<3>& a_W : {Vec<3>(0, 0, 0), Vec<3>(0, 0, -9.81), Vec<3>(1, 2, 3)}) {
    Rig rig(Noiseless());
    rig.Fix(rig->body, Tilted()).Fix(rig->acceleration, PlatformAcceleration{a_W, {7, 8, 9}}).Tick();
    const ImuMeasurement& measurement = rig[rig->measurement];
    EXPECT_THAT(Tilted().R_WB() * measurement.specific_force_B,
                IsNear(Vec<3>(a_W + Vec<3>(0, 0, 9.81)), 1e-14));
    EXPECT_THAT(Tilted().R_WB() * measurement.angular_velocity_B, IsNear(Tilted().w_W, 1e-15));
  }
}

// The specific force against the second derivative of the unit's position.
TEST(ImuTest, MeasuresAtItsPosition) {
  ImuParams params = Noiseless();
  params.p_B = {0.3, -0.2, 0.1};
  const auto angles = [](double t) { return Vec<3>(0.3 * t, -0.4 * std::sin(2 * t), 0.5 * t * t); };
  const auto origin = [](double t) { return Vec<3>(std::sin(t), t * t, std::cos(3 * t)); };
  const auto place = [&](double t) -> Vec<3> {
    return origin(t) + RotationFromEuler(angles(t)) * params.p_B;
  };
  const double t = 0.7, h = 1e-4;
  const auto second = [&](const auto& f) -> Vec<3> { return (f(t + h) - 2 * f(t) + f(t - h)) / (h * h); };
  const auto velocity = [&](double at) -> Vec<3> {  // the angular one, of R' R^T
    const Eigen::Matrix3d cross = (RotationFromEuler(angles(at + h)) - RotationFromEuler(angles(at - h))) /
                                  (2 * h) * RotationFromEuler(angles(at)).transpose();
    return {cross(2, 1), cross(0, 2), cross(1, 0)};
  };
  const Eigen::Matrix3d R_WB = RotationFromEuler(angles(t));
  Rig rig(params);
  rig.Fix(rig->body, PlatformState{origin(t), QuaternionFromRotation(R_WB), Vec<3>::Zero(), velocity(t)})
      .Fix(rig->acceleration,
           PlatformAcceleration{second(origin), (velocity(t + h) - velocity(t - h)) / (2 * h)})
      .Tick();
  EXPECT_THAT(R_WB * rig[rig->measurement].specific_force_B - Vec<3>(0, 0, 9.81),
              IsNear(second(place), 1e-5));
}

TEST(ImuTest, NoiseHasTheGivenDeviationsAndBiases) {
  const ImuParams params{.angular_velocity_noise = {0.005, 0.01, 0.002},
                         .angular_velocity_bias = {0.1, 0, -0.2},
                         .specific_force_bias = {0, 0.3, -0.4}};
  Rig rig(params);
  rig.Fix(rig->body, PlatformState{}).Fix(rig->acceleration, PlatformAcceleration{});
  Vec<6> expected, deviation;
  expected << params.angular_velocity_bias, params.specific_force_bias + Vec<3>(0, 0, 9.81);
  deviation << params.angular_velocity_noise, params.specific_force_noise;
  test::ErrorStatistics<6> statistics;
  for (int i = 0; i < 20000; ++i) {
    const ImuMeasurement& measurement = rig.Tick()[rig->measurement];
    Vec<6> values;
    values << measurement.angular_velocity_B, measurement.specific_force_B;
    statistics.Add(values - expected);
  }
  statistics.Expect(Vec<6>::Zero(), deviation);
}

const ImuMeasurement kMeasurement{{0.1, -0.2, 0.3}, {0.5, 0, 9.81}};

TEST(ImuErrorsTest, WithoutErrorsItPassesItsInput) {
  TestRig<ImuErrors> rig;
  rig.Fix(rig->measurement, kMeasurement).Tick();
  EXPECT_EQ(rig[rig->measured].angular_velocity_B, kMeasurement.angular_velocity_B);
  EXPECT_EQ(rig[rig->measured].specific_force_B, kMeasurement.specific_force_B);
}

/// Gravity seen from a unit that is turned by a little about y leans forward: g sin(e) along x.
TEST(ImuErrorsTest, AUnitThatSitsAskewSeesGravityAslant) {
  TestRig<ImuErrors> rig(ImuErrorsParams{.misalignment = 1});
  rig.Fix(rig->measurement, {Vec<3>::Zero(), {0, 0, 9.81}}).Tick();
  rig.Set(rig->unit, {.turn_B = {0, 0.02, 0}}).Tick();
  EXPECT_THAT(rig[rig->measured].specific_force_B,
              IsNear(Vec<3>(-9.81 * std::sin(0.02), 0, 9.81 * std::cos(0.02)), 1e-12));
}

/// Many units: each has a bias and a place of its own.
TEST(ImuErrorsTest, UnitsDifferByTheirDeviations) {
  constexpr int kUnits = 400;
  double bias = 0, turn = 0;
  for (int seed = 1; seed <= kUnits; ++seed) {
    DiagramBuilder builder;
    auto& errors = builder.Add<ImuErrors>(
        "errors",
        ImuErrorsParams{.misalignment = 0.01, .angular_velocity_bias = 0.02, .specific_force_bias = 0.3});
    const auto diagram = builder.BuildWithOpenInputs();
    Simulator simulator(*diagram, {.seed = static_cast<std::uint64_t>(seed)});
    simulator.context().Set(errors.measurement, kMeasurement);
    simulator.RunTo(0);
    const ImuErrors::Unit& unit = simulator.context().Eval(errors.unit);
    bias += unit.specific_force_bias.squaredNorm() / (3 * kUnits);
    turn += unit.turn_B.squaredNorm() / (3 * kUnits);
  }
  EXPECT_NEAR(std::sqrt(bias), 0.3, 0.02);
  EXPECT_NEAR(std::sqrt(turn), 0.01, 0.001);
}

TEST(ImuErrorsTest, BiasesWalkWithTheRootOfTime) {
  constexpr int kTicks = 20'000;
  constexpr double kWalk = 0.05;
  TestRig<ImuErrors> rig(ImuErrorsParams{.rate = Hz(100), .angular_velocity_walk = kWalk});
  rig.Fix(rig->measurement, kMeasurement).Tick();
  Vec<3> last = rig[rig->measured].angular_velocity_B;
  double squares = 0;
  for (int n = 0; n < kTicks; ++n) {
    const Vec<3> next = rig.Tick()[rig->measured].angular_velocity_B;
    squares += (next - last).squaredNorm() / 3;
    last = next;
  }
  EXPECT_NEAR(std::sqrt(squares / (0.01 * kTicks)), kWalk, 0.02 * kWalk);
  EXPECT_EQ(rig[rig->measured].specific_force_B, kMeasurement.specific_force_B);
}

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
  PoseRig rig(PoseSensorParams{.position_noise = {0, 0, 0}, .attitude_noise = {0, 0, 0}});
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
  PoseRig rig(params);
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
  PoseRig rig(params);
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
  PoseRig rig;
  rig.Fix(rig->platform, Somewhere()).Tick();
  EXPECT_DOUBLE_EQ(rig.simulator().next_tick_time(), 1.0 / 200);
  const PoseMeasurement held = rig[rig->pose];
  rig.RunTo(0.0049);
  EXPECT_EQ(rig[rig->pose].p_WB, held.p_WB);
  rig.RunTo(0.005);
  EXPECT_NE(rig[rig->pose].p_WB, held.p_WB);
}

CableSignals Cables() {
  return {Eigen::Vector4d(5.01234, 6, 7, 8), Eigen::Vector4d(0.1, -0.2, 0, 0.4),
          Eigen::Vector4d(100, 50, 0, 700), Eigen::Vector4d(5, 5.9, 7.1, 7.8)};
}

TEST(CableSensorsTest, WithoutErrorsPassTheTruth) {
  TestRig<CableSensors> rig;
  rig.Fix(rig->cables, Cables()).Tick();
  const CableSignals& measured = rig[rig->measured];
  EXPECT_EQ(measured.length, Cables().length);
  EXPECT_EQ(measured.length_rate, Cables().length_rate);
  EXPECT_EQ(measured.tension, Cables().tension);
  EXPECT_EQ(measured.rest_length, Cables().rest_length);
}

TEST(CableSensorsTest, LengthsHaveStepsAndOffsetsThatStay) {
  TestRig<CableSensors> rig(CableSensorsParams{.resolution = 0.001, .length_offset = 0.1});
  rig.Fix(rig->cables, Cables()).Tick();
  const CableVector first = rig[rig->measured].length;
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::remainder(first[i], 0.001), 0, 1e-12) << i;
  EXPECT_GT((first - Cables().length).norm(), 0.05);
  CableSignals longer = Cables();
  longer.length.array() += 0.25;
  rig.Fix(rig->cables, longer).Tick();
  EXPECT_THAT(Eigen::Vector4d(rig[rig->measured].length - first),
              IsNear(Eigen::Vector4d(Eigen::Vector4d::Constant(0.25)), 1e-9));
}

// The rate of a length that grows at 0.2 m/s follows the step response of a first-order lag.
TEST(CableSensorsTest, RatesAreFilteredDifferences) {
  TestRig<CableSensors> rig(CableSensorsParams{.rate_bandwidth = 10});
  CableSignals cables = Cables();
  const double pole = std::exp(-2 * std::numbers::pi * 10 * 1e-3);
  for (int n = 0; n < 50; ++n) {
    rig.Fix(rig->cables, cables).Tick();
    EXPECT_NEAR(rig[rig->measured].length_rate[1], 0.2 * (1 - std::pow(pole, n)), 1e-9) << n;
    cables.length[1] += 0.2e-3;
  }
}

TEST(CableSensorsTest, TensionsHaveNoiseThatGrowsWithThemAndAreNotNegative) {
  TestRig<CableSensors> rig(CableSensorsParams{.tension_noise = 0.02, .tension_offset = 5});
  rig.Fix(rig->cables, Cables());
  constexpr int kTicks = 4000;
  Eigen::Array4d mean = Eigen::Array4d::Zero(), squares = mean;
  for (int n = 0; n < kTicks; ++n) {
    const Eigen::Array4d tension = rig.Tick()[rig->measured].tension.array();
    EXPECT_GE(tension.minCoeff(), 0);
    mean += tension / kTicks;
    squares += tension.square() / kTicks;
  }
  EXPECT_NEAR(std::sqrt(squares[3] - mean[3] * mean[3]), 14, 1);
  EXPECT_GT((mean - Cables().tension.array()).abs().maxCoeff(), 2) << "offsets";
}

}  // namespace tenon::imu_test
