// Gains for cable robots of all sizes.

#include <tenon/diagrams/cdpr/cdpr_profile.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::cdpr_profile_test {

const YamlFile kShipped{"cable_robot"};

TEST(CdprProfile, ScaleIsMassDistanceOfTheAnchorsAndRadiusOfTheAttachments) {
  CdprDescription robot = test::ShippedFourCableRobot();
  const CdprScale scale = ScaleOf(robot, {0, 0, 2});
  EXPECT_EQ(scale.mass, 15);
  // From (0.075, 0.075, 2.093) to (3.5, 4.5, 4), the same for all four.
  EXPECT_NEAR(scale.length, std::hypot(3.425, 4.425, 1.907), 1e-12);
  EXPECT_NEAR(scale.arm, std::hypot(0.075, 0.075, 0.093), 1e-12);
}

TEST(CdprProfile, GivesTheWeightsInTheRobotsUnits) {
  CdprScale scale;
  scale.mass = 2;
  scale.length = 3;
  scale.arm = 0.5;
  scale.gravity = 12;  // t = 0.5 s, m g = 24 N
  const auto file = test::TemporaryPath("profile.yaml");
  std::ofstream(file) << R"(
mpc:
  horizon_t: 4
  num_steps: 7
  weights:
    position_l2: [9, 9, 18]
    velocity_l2_per_t2: 36
    attitude_l2_per_a2: 72
    angular_velocity_l2_per_a2_t2: 144
    tension_m2_g2: 576
pd: {stiffness_m_per_s2: 100, damping_m_per_s: 8}
)";
  const CdprProfile profile = LoadCdprProfile({file.string()}, scale);
  std::filesystem::remove(file);
  EXPECT_DOUBLE_EQ(profile.mpc.horizon, 2);
  EXPECT_EQ(profile.mpc.num_steps, 7);
  EXPECT_THAT(profile.mpc.weights.position, IsNear(Vec<3>(1, 1, 2), 1e-15));
  EXPECT_THAT(profile.mpc.weights.velocity, IsNear(Vec<3>(1, 1, 1), 1e-15));
  EXPECT_THAT(profile.mpc.weights.attitude, IsNear(Vec<3>(2, 2, 2), 1e-15));
  EXPECT_THAT(profile.mpc.weights.angular_velocity, IsNear(Vec<3>(1, 1, 1), 1e-15));
  EXPECT_DOUBLE_EQ(profile.mpc.weights.tension[0], 1);
  EXPECT_DOUBLE_EQ(profile.pd.stiffness[0], 200);
  EXPECT_DOUBLE_EQ(profile.pd.damping[0], 16);
}

/// The loop of a robot whose lengths are those of cdpr_4 times `length`, its masses times `mass`.
CdprLoopParams Similar(double length, double mass) {
  const double time = std::sqrt(length);
  CdprDescription robot = test::ShippedFourCableRobot();
  robot.mass *= mass;
  robot.inertia_B *= mass * length * length;
  for (CableDescription& cable : robot.cables) {
    cable.anchor_W *= length;
    cable.attachment_B *= length;
  }
  robot.cable.axial_stiffness *= mass;
  robot.cable.axial_damping *= mass * time;
  robot.cable.tension_max *= mass;
  robot.winch.time_constant *= time;
  robot.winch.reel_damping *= mass * time / length;
  const Eigen::Vector3d center = length * Eigen::Vector3d(0, 0, 2);
  const auto path =
      std::make_shared<EquilibriumPath>(robot, Path::Circle(center, 0.5 * length, 10 * time, 0.5 * time));
  CdprLoopParams params = test::WithMpc(robot, path);
  const CdprProfile profile = LoadCdprProfile(kShipped, ScaleOf(robot, path->path().At(0).position));
  const auto rate = [&](double hz) { return Hz(hz / time); };
  params.mpc->rate = rate(100);
  params.mpc->command_rate = rate(1000);
  params.mpc->weights = params.mpc->terminal_weights = profile.mpc.weights;
  params.mpc->horizon = std::round(profile.mpc.horizon * params.mpc->rate.hz()) / params.mpc->rate.hz();
  params.start_offset = length * Vec<3>(0.1, -0.2, 0.1);  // gains shape the return to the path
  params.control_rate = rate(1000);
  params.pose_sensor.rate = params.estimator.rate = rate(100);
  params.imu.rate = rate(200);
  params.pose_sensor.position_noise.setZero();
  params.pose_sensor.attitude_noise.setZero();
  params.imu.angular_velocity_noise.setZero();
  params.imu.specific_force_noise.setZero();
  params.estimator.noise.position *= length;
  params.estimator.noise.angular_velocity /= time;
  params.estimator.noise.length_rate *= length / time;
  params.estimator.initial_velocity *= length / time;
  return params;
}

/// Positions of the platform in units of the scaled lengths, ten per scaled second.
std::vector<Eigen::Vector3d> Fly(double length, double mass) {
  DiagramBuilder builder;
  auto& loop = builder.Add<CdprLoop>("loop", Similar(length, mass));
  Simulator simulator(builder.Build(), {.order = 4, .rtol = 1e-8, .atol = 1e-10});
  std::vector<Eigen::Vector3d> positions;
  for (int i = 1; i <= 20; ++i) {
    simulator.RunTo(i * 0.1 * std::sqrt(length));
    positions.push_back(simulator.context().Eval(loop.world.plant.platform).p_WB / length);
  }
  return positions;
}

// Dynamic similarity: with lengths times 4 and masses times 10, times double and forces grow tenfold. A gain
// that is not in that is not in the units of the robot would break it.
TEST(CdprProfile, SimilarRobotsFlyAlike) {
  const std::vector<Eigen::Vector3d> small = Fly(1, 1), large = Fly(4, 10);
  ASSERT_GT((small.back() - small.front()).norm(), 0.3);  // it has set out
  for (std::size_t i = 0; i < small.size(); ++i) EXPECT_THAT(large[i], IsNear(small[i], 1e-4)) << i;
}

}  // namespace tenon::cdpr_profile_test
