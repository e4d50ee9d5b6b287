#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <fmt/core.h>

namespace tenon::apps::quadruped_hardware_test {

const Scale kScale = ScaleOf(test::DogBot());

QuadrupedHardware Load(const std::string& file, const std::string& sensors = "") {
  return LoadHardware({file}, kScale, SensorChanges{{sensors}});
}

QuadrupedWorldParams WorldWith(const QuadrupedHardware& hardware) {
  QuadrupedWorldParams world;
  world.plant.robot = test::DogBot();  // joints of 60 N m and 6 rad/s
  SetHardware(hardware, Hz(1000), world);
  return world;
}

TEST(QuadrupedHardwareTest, IdealHardwareAddsNothing) {
  const QuadrupedWorldParams world = WorldWith(Load("ideal"));
  EXPECT_FALSE(world.hardware.command_delay || world.hardware.drive_errors || world.hardware.drive_lag ||
               world.imu.unit.any() || world.foot_sensor.mounted != FootSensing::kWorld);
  EXPECT_EQ(world.encoders.latency + world.foot_sensor.latency + world.imu.latency, 0);
  EXPECT_EQ(world.plant.robot.drive.friction, test::DogBot().drive.friction);
}

TEST(QuadrupedHardwareTest, DrivesAreRatedByTheRobotsOwnTorque) {
  const QuadrupedWorldParams world = WorldWith(Load("standard"));
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.friction, 0.02 * 60);
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.damping, 0.02 * 60 / 6);
  EXPECT_DOUBLE_EQ(world.plant.robot.drive.rotor_inertia, 60 / 7400.0);
  EXPECT_TRUE(world.plant.limit_speed);
  EXPECT_NEAR(world.hardware.drive_lag->time_constant, 1 / (2 * std::numbers::pi * 40), 1e-12);
  EXPECT_NEAR(world.encoders.Resolution(), 2 * std::numbers::pi / 16384, 1e-12);
  const double weight = 9.81 * test::DogBot().mass();
  EXPECT_NEAR(world.foot_sensor.threshold, 0.06 * weight, 1e-9);
  EXPECT_NEAR(world.foot_sensor.error.absolute, 0.01 * weight, 1e-9);
}

/// Delay from sensor to torque: the latency of the sensors and the delay of the link.
TEST(QuadrupedHardwareTest, RoughIsTwiceStandard) {
  const QuadrupedHardware standard = Load("standard"), rough = Load("rough");
  const auto delay = [](const QuadrupedHardware& hardware) {
    return hardware.link.delay + hardware.sensors.encoders.latency * hardware.sensors.encoders.rate.period();
  };
  EXPECT_NEAR(delay(standard), 0.002, 1e-12);
  EXPECT_NEAR(delay(rough), 0.004, 1e-12);
  EXPECT_EQ(rough.link.jitter, 2 * standard.link.jitter);
  EXPECT_EQ(*rough.drives.friction_ratio, 2 * *standard.drives.friction_ratio);
  EXPECT_EQ(*rough.drives.bandwidth, *standard.drives.bandwidth / 2);
  EXPECT_EQ(*rough.sensors.encoders.bits, *standard.sensors.encoders.bits - 1);
  EXPECT_EQ(rough.sensors.imu.unit.misalignment, 2 * standard.sensors.imu.unit.misalignment);
  EXPECT_EQ(rough.sensors.foot_sensor.error.relative, 2 * standard.sensors.foot_sensor.error.relative);
}

TEST(QuadrupedHardwareTest, AMapChangesKeysOfShippedHardware) {
  const QuadrupedHardware own =
      Load("{file: standard, link: {delay_s: 0.004}, drives: {bandwidth_hz: null}}");
  EXPECT_EQ(own.link.delay, 0.004);
  EXPECT_EQ(own.link.jitter, 0.0005);
  EXPECT_FALSE(own.drives.bandwidth) << "null is not set";
}

TEST(QuadrupedHardwareTest, KeysOfAScenarioOverrideThoseOfTheHardware) {
  const QuadrupedSensors both = Load("standard",
                                     "{imu: {acceleration_noise_m_per_s2: 0.5}, foot_force: {mounted: none}, "
                                     "encoders: {bits: null}}")
                                    .sensors;
  EXPECT_EQ(both.imu.specific_force_noise, Vec<3>::Constant(0.5)) << "one number for all axes";
  EXPECT_EQ(both.imu.angular_velocity_noise, Vec<3>::Constant(5.5e-3));
  EXPECT_EQ(both.foot_sensor.mounted, FootSensing::kNone);
  EXPECT_EQ(both.encoders.bits, 14) << "null is not set";
}

TEST(QuadrupedHardwareTest, TheEstimatorAssumesTheNoiseOfTheDataSheets) {
  const ContactAidedNoise ideal = BelievedNoise(Load("ideal").sensors),
                          standard = BelievedNoise(Load("standard").sensors);
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
        {"sensors: {encoders: {rate_hz: 0}}", "sensors.encoders.rate_hz"},
        {"sensors: {foot_force: {noise_N: 1}}", "noise_weight_ratio"},
        {"sensors: {imu: {misalignment_rad: -1}}", "sensors.imu.misalignment_rad"},
        {"sensors: {torque: {latency_samples: -1}}", "sensors.torque.latency_samples"}})
    EXPECT_TRUE(Throws<ParameterError>(
        [&, text = text] { YamlDocument::Parse(text, "own.yaml").Read<QuadrupedHardware>(&kScale); },
        "own.yaml:1:", key));
  EXPECT_TRUE(Throws<ParameterError>([] { Load("standart"); }, "'standart'", "'standard'"));
}

using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

QuadrupedScenario Scenario(const char* name, std::vector<std::string> settings) {
  return LoadScenario(name, settings, "tenon-quadruped").Read<QuadrupedScenario>();
}

// Ratios of A1 (12.78 kg, legs of 0.4 m, from its URDF) to DogBot (21.256 kg, 0.617 m).
constexpr double kWeight = (6 + 4 * (0.595 + 0.888 + 0.151 + 0.06)) / 21.256,
                 kLength = 0.4 / 0.6170347662107791;

TEST(QuadrupedScaleTest, ForcesGoWithTheWeightAndBlocksWithTheLegs) {
  const QuadrupedWalkParams dogbot = MakeWalkParams(Scenario("B1", {})),
                            a1 = MakeWalkParams(Scenario("B1", {"robot=a1", "scale_forces=true"}));
  EXPECT_NEAR(a1.world.plant.payload.mass, kWeight * dogbot.world.plant.payload.mass, 1e-9);
  EXPECT_NEAR(a1.world.plant.terrain.field->kinds[1].height, kLength * 0.035, 1e-12);
  EXPECT_NEAR(a1.locomotion.swing_planner.step.height, kLength * dogbot.locomotion.swing_planner.step.height,
              1e-12);
  EXPECT_NEAR(a1.locomotion.swing_planner.step.reflex.height, kLength * 0.1, 1e-12);
  const QuadrupedWalkParams pushed = MakeWalkParams(Scenario("A3", {"robot=a1", "scale_forces=true"}));
  EXPECT_NEAR(pushed.world.pulses[0].push.force_W[0], kWeight * 80, 1e-9);
}

TEST(QuadrupedScaleTest, TheLoadIsAtMostWhatTwoLegsHold) {
  const QuadrupedDescription robot = MakeWalkParams(Scenario("B1", {})).world.plant.robot;
  const double knee = HeldByTwoLegs(robot).torque;
  const auto loaded = [&](double held, const char* scale) {
    const std::string torque = fmt::format("robot.joint_limits.knee.torque_N_m={}", held * knee);
    return Scenario("B1", {torque, scale});
  };
  const auto load = [](const QuadrupedScenario& scenario) {
    return MakeWalkParams(scenario).world.plant.payload.mass;
  };
  EXPECT_NEAR(load(loaded(1.3, "scale_forces=true")), 0.3 * robot.mass(), 1e-6);
  EXPECT_EQ(load(loaded(1.3, "scale_forces=false")), 23);
  EXPECT_NEAR(load(loaded(3, "scale_forces=true")), 23, 1e-9);
  EXPECT_EQ(load(loaded(0.9, "scale_forces=true")), 0);

  EXPECT_THAT(Notes(loaded(3, "scale_forces=true")), IsEmpty());
  EXPECT_THAT(
      Notes(loaded(1.3, "scale_forces=true")),
      ElementsAre(HasSubstr("payload: 23 kg, 108 % of the robot's weight, are more than the 6.38 kg")));
  EXPECT_THAT(Notes(loaded(0.9, "scale_forces=false")),
              ElementsAre(HasSubstr("in a trot, two legs hold the robot"), HasSubstr("the robot may fall")));
}

// B's origin may lie anywhere on the trunk.
TEST(QuadrupedScaleTest, PointsOnTheTrunkKeepTheirPlacesRelativeToTheHips) {
  const QuadrupedScenario scenario = Scenario("B1", {"scale_forces=true"});
  SizeRatio ratio = RatioOf(scenario);
  EXPECT_LT(ratio.offset.norm(), 1e-12);
  ratio.length = 2;
  ratio.offset = {0.1, 0, 0.3};
  EXPECT_LT((ScaledToRobot(scenario, ratio).payload.position_m - Vec<3>(0.1, 0, 0.5)).norm(), 1e-12);
}

TEST(QuadrupedScaleTest, DogBotIsNotScaled) {
  const QuadrupedScenario scenario = Scenario("B2", {"scale_forces=true"});
  EXPECT_EQ(ScaledToRobot(scenario, RatioOf(scenario)).random_forces[1].upper_N, 40);
  EXPECT_EQ(RatioOf(Scenario("B2", {"robot=a1"})).weight, 1);  // scale_forces is false
}

// The stiffness over weight times leg length is equal for all robots.
TEST(QuadrupedScaleTest, JointsAreAsStiffAsTheRobotIsHeavy) {
  const auto stiffness = [](const QuadrupedScenario& scenario) {
    const QuadrupedStandParams params = MakeStandParams(scenario);
    const RobotScale scale = ScaleOf(params.pd.robot);
    return Eigen::Vector2d(params.pd.stiffness / (scale.Weight() * scale.length),
                           params.pd.damping / params.pd.stiffness / scale.Time());
  };
  EXPECT_TRUE(stiffness(Scenario("stand", {"robot=a1"})).isApprox(stiffness(Scenario("stand", {})), 1e-9));
  EXPECT_NEAR(MakeStandParams(Scenario("stand", {})).pd.stiffness, 500, 1e-4);
  EXPECT_NEAR(MakeStandParams(Scenario("stand", {})).pd.damping, 10, 1e-6);
  EXPECT_EQ(MakeStandParams(Scenario("stand", {"pd.stiffness_N_m_per_rad=70"})).pd.stiffness, 70);
}

}  // namespace tenon::apps::quadruped_hardware_test
