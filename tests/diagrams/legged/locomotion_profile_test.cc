#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::locomotion_profile_test {

// The gains of the standard profile are round numbers in SI units for DogBot.
TEST(LocomotionProfileTest, IsRoundInSiUnitsForDogBot) {
  const RobotScale scale = ScaleOf(test::DogBot());
  EXPECT_NEAR(scale.Weight(), 9.81 * (9.3 + 4 * (0.836 + 1.851 + 0.302)), 1e-9);
  EXPECT_NEAR(scale.length, 0.315 + std::hypot(0.035, 0.3), 1e-12);
  const LocomotionProfile profile = LoadLocomotionProfile({"standard"}, scale);
  const WholeBodyGains& gains = profile.whole_body;
  constexpr double kDigits = 1e-7;
  EXPECT_NEAR(gains.com_stiffness / 2500, 1, kDigits);
  EXPECT_NEAR(gains.com_damping / 400, 1, kDigits);
  EXPECT_NEAR(gains.com_limit / 0.08, 1, kDigits);
  EXPECT_NEAR(gains.swing_limit / 200, 1, kDigits);
  EXPECT_NEAR(gains.tip_margin, 0.05, 2e-4);
  EXPECT_NEAR(gains.qp.wrench_weight, 100, 0);
  EXPECT_NEAR(gains.qp.moment_weight / 30, 1, kDigits);
  EXPECT_NEAR(gains.qp.tilt_weight / 500, 1, kDigits);
  EXPECT_NEAR(gains.qp.yaw_weight / 3, 1, kDigits);
  EXPECT_NEAR(gains.qp.acceleration_weight / 1e-4, 1, kDigits);
  EXPECT_NEAR(gains.qp.slack_weight / 1e6, 1, kDigits);
  EXPECT_NEAR(profile.ground.roughness / 0.03, 1, kDigits);
  EXPECT_NEAR(profile.ground.level_walk / 0.02, 1, kDigits);
  EXPECT_NEAR(profile.ground.start_roughness / 0.005, 1, kDigits);
  EXPECT_NEAR(LoadGaits({"standard"}, scale).touchdown_force / 4, 1, kDigits);
}

// A robot of twice the length and eight times the mass has the same dimensionless gains: the frequency of the
// CoM times the time unit, its damping ratio, and the ratios of the costs.
TEST(LocomotionProfileTest, RobotsOfAllSizesAreAlike) {
  const RobotScale small = ScaleOf(test::DogBot()), large{8 * small.mass, 2 * small.length};
  const LocomotionProfile a = LoadLocomotionProfile({"standard"}, small),
                          b = LoadLocomotionProfile({"standard"}, large);
  const auto frequency = [](const LocomotionProfile& p, const RobotScale& s) {
    return std::sqrt(p.whole_body.com_stiffness / s.mass) * s.Time();
  };
  EXPECT_NEAR(frequency(a, small), frequency(b, large), 1e-9);
  const auto damping_ratio = [](const LocomotionProfile& p, const RobotScale& s) {
    return p.whole_body.com_damping / (2 * std::sqrt(p.whole_body.com_stiffness * s.mass));
  };
  EXPECT_NEAR(damping_ratio(a, small), damping_ratio(b, large), 1e-9);
  // The costs of a force of 1 % of the weight, of its moment at the length of a leg, and of an acceleration
  // of g.
  const auto costs = [](const LocomotionProfile& p, const RobotScale& s) {
    const WholeBodyQpParams& qp = p.whole_body.qp;
    const double force = 0.01 * s.Weight(), moment = force * s.length;
    return Eigen::Vector4d(qp.wrench_weight * force * force, qp.moment_weight * moment * moment,
                           qp.acceleration_weight * 9.81 * 9.81, qp.slack_weight * 9.81 * 9.81);
  };
  const Eigen::Vector4d of_a = costs(a, small), of_b = costs(b, large);
  EXPECT_TRUE((of_a / of_a[0]).isApprox(of_b / of_b[0], 1e-9));
  EXPECT_NEAR(b.ground.roughness, 2 * a.ground.roughness, 1e-12);
  EXPECT_NEAR(LoadGaits({"standard"}, large).touchdown_force,
              8 * LoadGaits({"standard"}, small).touchdown_force, 1e-9);
}

// Without its key, the observer of Focchi et al. has the published gains; a profile changes each alone.
TEST(LocomotionProfileTest, GainsOfTheObserverOfFocchi) {
  const auto load = [](const char* profile) {
    const LocomotionProfile loaded = LoadLocomotionProfile(YamlFile{profile}, ScaleOf(test::DogBot()));
    return MakeObserver(test::DogBot(), loaded).focchi;
  };
  const ComObserverGains published = load("standard");
  EXPECT_EQ(published.force_bandwidth, 25);
  EXPECT_EQ(published.torque_bandwidth, 10);
  EXPECT_EQ(published.force_source, ForceSource::kMomentum);
  const ComObserverGains faster =
      load("{file: standard, observer: {focchi: {force_bandwidth_rad_per_s: 60}}}");
  EXPECT_EQ(faster.force_bandwidth, 60);
  EXPECT_EQ(faster.torque_bandwidth, 10);
  EXPECT_EQ(faster.force_source, ForceSource::kMomentum);
  EXPECT_TRUE(Throws<ParameterError>([&] { load("{file: standard, observer: {ndo_gain: [1, 2]}}"); },
                                     "observer.ndo_gain"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] { load("{file: standard, observer: {com: {torque_bandwidth_rad_per_s: [9, 9]}}}"); },
      "com.torque_bandwidth_rad_per_s"));
}

// The published code of the thesis's author: 2500 N/m, 50 N s/m for DogBot.
TEST(LocomotionProfileTest, CodeOfTheThesisIsRoundForDogBot) {
  const LocomotionProfile code = LoadLocomotionProfile({"thesis_code"}, ScaleOf(test::DogBot()));
  EXPECT_NEAR(code.whole_body.com_stiffness / 2500, 1, 1e-7);
  EXPECT_NEAR(code.whole_body.com_damping / 50, 1, 1e-7);
  const LocomotionProfile sliding = LoadLocomotionProfile({"sliding"}, ScaleOf(test::DogBot()));
  EXPECT_NEAR(sliding.whole_body.sliding.value().swing.layer / 0.02, 1, 1e-7);
}

TEST(LocomotionProfileTest, RefusesGainsOfOneRobot) {
  const auto load = [](const char* profile) {
    LoadLocomotionProfile(YamlFile{profile}, ScaleOf(test::DogBot()));
  };
  EXPECT_TRUE(
      Throws<ParameterError>([&] { load("{file: standard, whole_body: {com_stiffness_N_per_m: 2500}}"); },
                             "com_stiffness_N_per_m", "com_stiffness_mg_per_l"));
  EXPECT_TRUE(Throws<ParameterError>([&] { load("{file: standard, ground: {roughness_m: 0.03}}"); },
                                     "roughness_m", "roughness_l"));
}

}  // namespace tenon::locomotion_profile_test
