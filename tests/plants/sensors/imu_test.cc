#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::imu_test {
namespace {

using Rig = TestRig<Imu>;

ImuParams Noiseless() {
  ImuParams params;
  params.angular_velocity_noise.setZero();
  params.specific_force_noise.setZero();
  return params;
}

PlatformState Tilted() {
  return {
      {0, 0, 0}, QuaternionFromRotation(RotationFromEuler({0.3, -0.2, 1})), Vec<3>::Zero(), {0.4, 0.5, -0.6}};
}

TEST(ImuTest, AtRestReadsGravityUpwards) {
  Rig rig(Noiseless());
  rig.Fix(rig->body, PlatformState{}).Fix(rig->acceleration, PlatformAcceleration{}).Tick();
  EXPECT_EQ(rig[rig->measurement].specific_force_B, Vec<3>(0, 0, 9.81));
  EXPECT_EQ(rig[rig->measurement].angular_velocity_B, Vec<3>::Zero());
}

TEST(ImuTest, ReadsInTheBodysAxes) {
  Rig rig(Noiseless());
  rig.Fix(rig->body, Tilted()).Fix(rig->acceleration, PlatformAcceleration{{1, 2, 3}, {7, 8, 9}}).Tick();
  const Eigen::Matrix3d R_WB = RotationFromEuler({0.3, -0.2, 1});
  const ImuMeasurement& measurement = rig[rig->measurement];
  EXPECT_THAT(R_WB * measurement.specific_force_B, IsNear(Vec<3>(1, 2, 12.81), 1e-14));
  EXPECT_THAT(R_WB * measurement.angular_velocity_B, IsNear(Tilted().w_W, 1e-15));
}

// Against the second derivative of the unit's place in a motion that is known.
TEST(ImuTest, OffTheOriginFeelsTheRotationToo) {
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

TEST(ImuTest, InFreeFallReadsNothing) {
  Rig rig(Noiseless());
  rig.Fix(rig->body, Tilted()).Fix(rig->acceleration, PlatformAcceleration{.a_W = {0, 0, -9.81}}).Tick();
  EXPECT_EQ(rig[rig->measurement].specific_force_B, Vec<3>::Zero());
}

TEST(ImuTest, NoiseHasTheGivenDeviationsAndBiases) {
  // The bounds are 4 deviations of the mean and of the deviation of n normal numbers.
  const int n = 20000;
  ImuParams params;
  params.angular_velocity_noise = {0.005, 0.01, 0.002};
  params.angular_velocity_bias = {0.1, 0, -0.2};
  params.specific_force_bias = {0, 0.3, -0.4};
  Rig rig(params);
  rig.Fix(rig->body, PlatformState{}).Fix(rig->acceleration, PlatformAcceleration{});
  Vec<6> expected, deviation;
  expected << params.angular_velocity_bias, params.specific_force_bias + Vec<3>(0, 0, 9.81);
  deviation << params.angular_velocity_noise, params.specific_force_noise;
  Vec<6> sum = Vec<6>::Zero(), squares = Vec<6>::Zero(), last = Vec<6>::Zero(), products = Vec<6>::Zero();
  for (int i = 0; i < n; ++i) {
    const ImuMeasurement& measurement = rig.Tick()[rig->measurement];
    Vec<6> error;
    error << measurement.angular_velocity_B, measurement.specific_force_B;
    error -= expected;
    sum += error;
    squares += error.cwiseAbs2();
    products += error.cwiseProduct(last);
    last = error;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(sum[i] / n, 0, 4 * deviation[i] / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(squares[i] / n) / deviation[i], 1, 4 / std::sqrt(2 * n));
    EXPECT_NEAR(products[i] / n, 0, 4 * deviation[i] * deviation[i] / std::sqrt(n));
  }
}

TEST(ImuTest, SamplesAtItsRate) {
  ImuParams params;
  params.rate = Hz(400);
  Rig rig(params);
  rig.Fix(rig->body, PlatformState{}).Fix(rig->acceleration, PlatformAcceleration{}).Tick();
  EXPECT_DOUBLE_EQ(rig.simulator().next_tick_time(), 1.0 / 400);
}

TEST(ImuTest, OnAHangingPlatformFeedsASampledController) {
  // No loop from the command through the acceleration back to the controller: the motors' lag is between.
  const CdprPlantParams hanging = test::Hanging();
  DiagramBuilder builder;
  auto& plant = builder.Add<CdprPlant>("plant", hanging);
  auto& imu = builder.Add<Imu>("imu", Noiseless());
  builder.Connect(plant.platform, imu.body);
  builder.Connect(plant.acceleration, imu.acceleration);
  auto& command =
      builder.AddFunction("command", Sampled{Hz(1000)}, Uses(imu.measurement), [&](const ImuMeasurement& m) {
        return CableVector(hanging.initial_tension * (m.specific_force_B[2] / 9.81));
      });
  builder.Connect(command, plant.command);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(0.5);
  const ImuMeasurement& measurement = simulator.context().Eval(imu.measurement);
  EXPECT_THAT(measurement.specific_force_B, IsNear(Vec<3>(0, 0, 9.81), 1e-6));
  EXPECT_THAT(measurement.angular_velocity_B, IsNear(Vec<3>(0, 0, 0), 1e-6));
}

TEST(ImuTest, DoesNotAllocate) {
  Rig rig;
  rig.Fix(rig->body, Tilted()).Fix(rig->acceleration, PlatformAcceleration{}).RunTo(0.1);
  AllocationGuard guard;
  rig.RunTo(0.2);
  EXPECT_EQ(guard.count(), 0);
}

TEST(ImuTest, RefusesParametersThatMakeNoSense) {
  ImuParams params;
  params.specific_force_noise = {0, 0, -1};
  EXPECT_TRUE(Refuses<Imu>(params, "specific_force_noise"));
  params = {};
  params.angular_velocity_noise[0] = INFINITY;
  EXPECT_TRUE(Refuses<Imu>(params, "angular_velocity_noise"));
  params = {};
  params.angular_velocity_bias[1] = NAN;
  EXPECT_TRUE(Refuses<Imu>(params, "bias", "rad/s"));
  params = {};
  params.p_B[2] = NAN;
  EXPECT_TRUE(Refuses<Imu>(params, "p_B, where the IMU is, is not finite", "give metres"));
  params = {};
  params.gravity = NAN;
  EXPECT_TRUE(Refuses<Imu>(params, "gravity"));
}

TEST(ImuTest, NoiseAndBiasesAreSetInARun) {
  ImuParams params;
  params.angular_velocity_noise = {0.1, 0.2, 0.3};
  params.specific_force_noise = {1, 2, 3};
  params.angular_velocity_bias = {0.01, 0, 0};
  params.specific_force_bias = {0, 0.5, 0};
  Rig rig(Noiseless()), built(params);
  rig.Set(rig->angular_velocity_noise, params.angular_velocity_noise)
      .Set(rig->specific_force_noise, params.specific_force_noise)
      .Set(rig->angular_velocity_bias, params.angular_velocity_bias)
      .Set(rig->specific_force_bias, params.specific_force_bias);
  for (Rig* each : {&rig, &built})
    each->Fix(each->system().body, Tilted()).Fix(each->system().acceleration, PlatformAcceleration{}).Tick();
  EXPECT_EQ(rig[rig->measurement].angular_velocity_B, built[built->measurement].angular_velocity_B);
  EXPECT_EQ(rig[rig->measurement].specific_force_B, built[built->measurement].specific_force_B);
  rig.Set(rig->specific_force_bias, {0, 0, 100}).Tick();
  EXPECT_GT(rig[rig->measurement].specific_force_B[2], 80);
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        rig.Set(rig->specific_force_noise, {0, -1, 0});
      },
      "specific_force_noise is (0, -1, 0)"));
}

}  // namespace
}  // namespace tenon::imu_test
