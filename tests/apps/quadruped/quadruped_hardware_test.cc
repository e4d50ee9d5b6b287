#include <tenon/apps/quadruped/quadruped_hardware.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace tenon::apps::quadruped_hardware_test {
namespace {

QuadrupedWorldParams WorldWith(const HardwareScenario& hardware) {
  QuadrupedWorldParams world;
  world.plant.robot = test::DogBot();  // joints of 60 N m and 6 rad/s
  SetHardware(hardware, Hz(1000), world);
  return world;
}

TEST(QuadrupedHardwareTest, IdealHardwareAddsNothing) {
  const QuadrupedWorldParams world = WorldWith(LoadHardware({"ideal"}));
  EXPECT_FALSE(world.hardware.command_delay || world.hardware.drive_errors || world.hardware.drive_lag ||
               world.hardware.imu_errors || world.hardware.foot_sensing != FootSensing::kWorld);
  EXPECT_EQ(world.hardware.encoder_delay + world.hardware.foot_delay + world.hardware.imu_delay, 0);
  EXPECT_EQ(world.plant.robot.drive.friction, test::DogBot().drive.friction);
}

TEST(QuadrupedHardwareTest, FeetMayHaveNoSensors) {
  SensorScenario none;
  none.foot_force.mounted = FootSensing::kNone;
  const HardwareScenario standard = LoadHardware({"standard"});
  EXPECT_EQ(WorldWith(standard).hardware.foot_sensing, FootSensing::kShank);
  EXPECT_EQ(WorldWith(WithSensors(standard, none)).hardware.foot_sensing, FootSensing::kNone);
}

TEST(QuadrupedHardwareTest, DrivesAreRatedByTheRobotsOwnTorque) {
  const QuadrupedWorldParams world = WorldWith(LoadHardware({"standard"}));
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.friction, 0.02 * 60);
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.damping, 0.02 * 60 / 6);
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.rotor_inertia, 60 / 7400.0);
  EXPECT_TRUE(world.plant.limit_speed);
  EXPECT_NEAR(world.hardware.drive_lag->time_constant, 1 / (2 * std::numbers::pi * 40), 1e-12);
  EXPECT_NEAR(world.encoders.resolution, 2 * std::numbers::pi / 16384, 1e-12);
  const double weight = 9.81 * test::DogBot().mass();
  EXPECT_NEAR(world.foot_sensor.threshold, 0.06 * weight, 1e-9);
  EXPECT_NEAR(world.foot_sensor.error.absolute, 0.01 * weight, 1e-9);
}

/// Delay from sensor to torque: the latency of the sensors and the delay of the link.
TEST(QuadrupedHardwareTest, RoughIsTwiceStandard) {
  const HardwareScenario standard = LoadHardware({"standard"}), rough = LoadHardware({"rough"});
  const auto delay = [](const HardwareScenario& hardware) {
    return hardware.link.delay_s +
           *hardware.sensors.encoders.latency_samples / *hardware.sensors.encoders.rate_hz;
  };
  EXPECT_NEAR(delay(standard), 0.002, 1e-12);
  EXPECT_NEAR(delay(rough), 0.004, 1e-12);
  EXPECT_EQ(rough.link.jitter_s, 2 * standard.link.jitter_s);
  EXPECT_EQ(*rough.drives.friction_ratio, 2 * *standard.drives.friction_ratio);
  EXPECT_EQ(*rough.drives.bandwidth_hz, *standard.drives.bandwidth_hz / 2);
  EXPECT_EQ(*rough.sensors.encoders.bits, *standard.sensors.encoders.bits - 1);
  EXPECT_EQ(*rough.sensors.imu.misalignment_rad, 2 * *standard.sensors.imu.misalignment_rad);
  EXPECT_EQ(*rough.sensors.foot_force.noise_ratio, 2 * *standard.sensors.foot_force.noise_ratio);
}

TEST(QuadrupedHardwareTest, AMapChangesKeysOfShippedHardware) {
  const HardwareScenario own = LoadHardware({"{file: standard, link: {delay_s: 0.004}}"});
  EXPECT_EQ(own.link.delay_s, 0.004);
  EXPECT_EQ(own.link.jitter_s, 0.0005);
  EXPECT_EQ(own.drives.bandwidth_hz, 40);
}

TEST(QuadrupedHardwareTest, KeysOfAScenarioOverrideThoseOfTheHardware) {
  SensorScenario own;
  own.imu.acceleration_noise_m_per_s2 = 0.5;
  own.foot_force.mounted = FootSensing::kWorld;
  const HardwareScenario both = WithSensors(LoadHardware({"standard"}), own);
  EXPECT_EQ(both.sensors.imu.acceleration_noise_m_per_s2, 0.5);
  EXPECT_EQ(both.sensors.imu.angular_velocity_noise_rad_per_s, 5.5e-3);
  EXPECT_EQ(both.sensors.foot_force.mounted, FootSensing::kWorld);
  EXPECT_EQ(both.sensors.encoders.bits, 14);
}

TEST(QuadrupedHardwareTest, TheEstimatorAssumesTheNoiseOfTheDataSheets) {
  const ContactAidedNoise ideal = BelievedNoise(LoadHardware({"ideal"})),
                          standard = BelievedNoise(LoadHardware({"standard"}));
  EXPECT_GT(ideal.encoder, 0);
  EXPECT_GT(ideal.specific_force, 0);
  EXPECT_EQ(standard.specific_force, 0.038);
  EXPECT_NEAR(standard.encoder, 2 * std::numbers::pi / 16384 / std::sqrt(12), 1e-12)
      << "uniform within a quantization step";
}

TEST(QuadrupedHardwareTest, RefusesBadKeysWithTheirPlace) {
  for (const auto& [text, key] :
       {std::pair{"link: {delay_s: 0.001, jitter_s: 0.002}", "link.jitter_s"},
        {"drives: {bandwidth_hz: 0}", "drives.bandwidth_hz"},
        {"drives: {friction_ratio: 2}", "drives.friction_ratio"},
        {"drives: {rotor_acceleration_rad_per_s2: 0}", "drives.rotor_acceleration_rad_per_s2"},
        {"sensors: {encoders: {bits: 0}}", "sensors.encoders.bits"},
        {"sensors: {imu: {misalignment_rad: -1}}", "sensors.imu.misalignment_rad"},
        {"sensors: {torque: {latency_samples: -1}}", "sensors.torque.latency_samples"}})
    EXPECT_TRUE(Throws<ParameterError>(
        [&, text = text] { YamlDocument::Parse(text, "own.yaml").Read<HardwareScenario>(); },
        "own.yaml:1:", key));
  EXPECT_TRUE(Throws<ParameterError>([] { LoadHardware({"standart"}); }, "'standart'", "'standard'"));
}

}  // namespace
}  // namespace tenon::apps::quadruped_hardware_test
