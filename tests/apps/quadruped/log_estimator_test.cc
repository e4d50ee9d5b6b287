// The options --estimate and --identify: estimator and observers on logs, of runs and of a robot that stands
// tilted, which is written here.

#include <tenon/plants/signals/ros2_signals.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <numbers>

namespace tenon::apps_log_estimator_test {

using namespace ros2;
using test::Column, ::testing::HasSubstr;

constexpr double kTilt = 0.1;  // of the standing robot about y [rad]

class LogEstimatorTest : public test::AppTest {
 protected:
  LogEstimatorTest() : AppTest(TENON_QUADRUPED) {}
  std::string mcap() const { return (out / "run.mcap").string(); }
  /// Estimates from the log, expects the exit code, and returns what the app printed.
  std::string Estimate(const std::string& arguments, int exit_code = 0) const {
    const test::Result result = test::RunCommand(app + " --estimate " + mcap() + " " + arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.text;
    return result.text;
  }
  nlohmann::json Figures() const {
    return nlohmann::json::parse(ReadText(out / "estimate" / "summary.json"));
  }

  /// A second of DogBot that stands at rest, tilted, without odometry, with the clock of a wall, joints in
  /// reverse order, and, from 0.5 s on, no sample for `gap` [s].
  struct Standing {
    std::string without = "/none", imu_frame = "base_link", foot_frame = "contact_front_left";
    double gap = 0;
    bool effort = true;
  };
  void WriteStanding(const Standing& with) const {
    std::filesystem::create_directories(out);
    const QuadrupedDescription robot = test::DogBot();
    sensor_msgs::JointState joints;
    for (int j = kNumJoints; j-- > 0;) {
      joints.name.push_back(robot.joint(j).name);
      joints.position.push_back(robot.stance[j]);
    }
    joints.velocity.resize(kNumJoints);
    if (with.effort) joints.effort.resize(kNumJoints);
    sensor_msgs::Imu imu = MakeImu(with.imu_frame);
    imu.linear_acceleration = {.x = -9.81 * std::sin(kTilt), .z = 9.81 * std::cos(kTilt)};
    geometry_msgs::WrenchStamped foot;
    foot.wrench.force.z = robot.mass() * 9.81 / 4;
    McapFile file(mcap());
    std::map<std::string, std::uint16_t> topics;
    const auto write = [&](const std::string& topic, double time, auto message) {
      if (topic == with.without) return;
      const auto& type = internal::TypeInfoOf<decltype(message)>();
      if (!topics.contains(topic)) topics[topic] = file.AddTopic(topic, type);
      message.header.stamp = StampOf(1.7e9 + time);
      std::vector<char> cdr;
      internal::WriteMcapMessage(type, &message, cdr);
      file.Write(topics[topic], time, cdr);
    };
    for (int i = 0; i <= 500; ++i) {
      const double time = 0.002 * i;
      if (time > 0.5 && time < 0.5 + with.gap) continue;
      write("/joint_states", time, joints);
      write("/imu", time, imu);
      for (const std::string leg : kLegNames) {
        foot.header.frame_id = leg == "front_left" ? with.foot_frame : "contact_" + leg;
        write("/foot_force/" + leg, time, foot);
      }
    }
  }
};

// The push of 20 N is known, the pose by the plant, and the estimate that the run itself had by its log.
TEST_F(LogEstimatorTest, ARunIsEstimatedFromItsRecordingAsWellAsInTheRun) {
  Run("flat --duration 3 --mcap --set hardware=standard --set walk.state=estimated --set "
      "'forces=[{force_N: [0, 20, 0], start_s: 1, duration_s: 9}]'");
  Estimate("");
  const nlohmann::json figures = Figures();
  EXPECT_EQ(figures["reference"], "ground_truth");
  EXPECT_EQ(figures["rate_hz"], 1000);
  EXPECT_EQ(figures["gaps"], 0);
  for (const char* key : {"velocity_estimate_error_rms_m_per_s", "tilt_estimate_error_rms_rad"}) {
    EXPECT_LT(figures[key], 0.01) << key;
    EXPECT_LT(figures[key], 1.2 * figures["recorded_" + std::string(key)].get<double>()) << key;
  }
  const std::vector<double> x = Column(out / "estimate", "estimator.estimate.state.p_WB.x [m]"),
                            of_run = Column(out, "loop.world.plant.state.p_WB.x [m]"),
                            force = Column(out / "estimate", "observer.wrench.force_W.y [N]");
  ASSERT_EQ(x.size(), of_run.size());
  EXPECT_GT(of_run.back(), 0.1);
  double mean = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i], of_run[i], 0.01);
    if (i > 300) mean += force[i] / static_cast<double>(x.size() - 301);
  }
  EXPECT_NEAR(mean, 20, 3);
  Estimate("--set sensors.foot_force.mounted=none --observer com --duration 2");
  EXPECT_LT(Figures()["velocity_estimate_error_rms_m_per_s"], 0.01);
  EXPECT_EQ(Figures()["observer"], "com");
  EXPECT_NEAR(Figures()["simulated_s"], 2, 1e-9);
}

TEST_F(LogEstimatorTest, ARobotWithoutOdometryStandsAtTheOriginWithItsTilt) {
  WriteStanding({});
  Estimate("flat");
  EXPECT_NEAR(Figures()["start_stamp_s"], 1.7e9, 1e-3);
  EXPECT_EQ(Figures()["rate_hz"], 500);
  EXPECT_NEAR(Figures()["simulated_s"], 1, 1e-6);
  const QuadrupedDescription robot = test::DogBot();
  double lowest = 0;  // of the centres of the feet relative to the trunk, by a rotation about y
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Eigen::Vector3d foot = robot.FootPosition(leg, robot.stance);
    lowest = std::min(lowest, std::cos(kTilt) * foot.z() - std::sin(kTilt) * foot.x());
  }
  const auto last = [&](const std::string& name) {
    return Column(out / "estimate", "estimator.estimate.state." + name).back();
  };
  EXPECT_NEAR(last("q_WB.y"), std::sin(kTilt / 2), 1e-3);
  EXPECT_NEAR(last("q_WB.z"), 0, 1e-3);
  EXPECT_NEAR(last("p_WB.z [m]"), robot.foot_radius - lowest, 2e-3);
  EXPECT_NEAR(last("v_W.x [m/s]"), 0, 1e-3);
  EXPECT_NEAR(last("q.front_left_knee [rad]"), robot.stance[2], 1e-12);
}

TEST_F(LogEstimatorTest, GapsAndMessagesThatAreNoSamplesAreTold) {
  WriteStanding({.gap = 0.1});
  EXPECT_THAT(Estimate("flat"), HasSubstrs("/imu: 1 gaps", "0.1 s", "t = 0.500 s"));
  EXPECT_EQ(Figures()["gaps"], 6);
  EXPECT_NEAR(Figures()["longest_gap_s"], 0.1, 1e-6);
  std::filesystem::resize_file(mcap(), std::filesystem::file_size(mcap()) * 3 / 4);
  EXPECT_THAT(Estimate("flat"), HasSubstr("read up to byte"));
}

TEST_F(LogEstimatorTest, RefusesLogsThatDoNotFit) {
  for (const std::string topic : {"/joint_states", "/imu", "/foot_force/rear_left"}) {
    WriteStanding({.without = topic});
    EXPECT_THAT(Estimate("flat", 2), HasSubstrs(topic, "record it"));
  }
  Estimate("flat --set sensors.foot_force.mounted=none");  // needs no such topic
  WriteStanding({.imu_frame = "elsewhere"});
  EXPECT_THAT(Estimate("flat", 2), HasSubstrs("/imu", "'elsewhere'", "base_link"));
  WriteStanding({.foot_frame = "elsewhere"});
  EXPECT_THAT(Estimate("flat", 2), HasSubstrs("/foot_force/front_left", "'elsewhere'"));
  WriteStanding({.effort = false});
  EXPECT_THAT(Estimate("flat", 2), HasSubstrs("/joint_states", "effort"));
  WriteStanding({});
  EXPECT_THAT(Estimate("flat --set robot=a1", 2), HasSubstrs("FL_hip_joint", "--set robot"));
  EXPECT_THAT(Estimate("stand", 2), HasSubstr("'stand'"));
  EXPECT_THAT(Estimate("", 2), HasSubstr("no scenario"));
  EXPECT_THAT(Estimate("flat --gait trot", 2), HasSubstr("--estimate"));
  std::filesystem::resize_file(mcap(), 3000);
  EXPECT_THAT(Estimate("flat", 2), HasSubstrs("message of the topic /joint_states", "of 3000"));
  std::filesystem::resize_file(mcap(), 4);
  EXPECT_THAT(Estimate("flat", 2), HasSubstr("no MCAP"));
}

// The truth is standard.yaml on DogBot's drives of 60 N m and 6 rad/s; the torque is measured 1 ms late.
TEST_F(LogEstimatorTest, DrivesAndLoadOfARunAreIdentified) {
  Run("flat --gait crawl --duration 10 --mcap --set hardware=standard --set walk.state=estimated --set "
      "'payload={mass_kg: 3, position_m: [0.05, 0.02, 0.1], edges_m: [0.2, 0.2, 0.1]}'");
  const test::Result result = test::RunCommand(app + " --identify " + out.string());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const nlohmann::json figures = nlohmann::json::parse(ReadText(out / "identify" / "summary.json"));
  const auto expect = [&](const char* key, double truth) {
    EXPECT_NEAR(figures[key]["value"], truth, 0.05 * truth) << key;
    EXPECT_GT(figures[key]["deviation"], 0) << key;
    EXPECT_LT(figures[key]["deviation"], 0.05 * truth) << key;
  };
  expect("leg_mass_ratio", 1);
  expect("rotor_inertia_kg_m2", 60 / 7400.0);
  expect("damping_N_m_s_per_rad", 0.02 * 60 / 6);
  expect("friction_N_m", 0.02 * 60);
  expect("torque_delay_s", 0.002);
  expect("torque_lag_s", 1 / (2 * std::numbers::pi * 40));
  expect("payload_kg", 3);
  EXPECT_NEAR(figures["payload_x_m"]["value"], 0.05, 0.01);
  EXPECT_NEAR(figures["payload_y_m"]["value"], 0.02, 0.01);
  for (const std::string& scenario : {"flat --set hardware=" + (out / "identify/hardware.yaml").string(),
                                      (out / "identify/identified.yaml").string()})
    EXPECT_EQ(test::RunCommand(app + " " + scenario + " --duration 0.1 --out " + (out / "again").string())
                  .exit_code,
              0)
        << scenario;
}

TEST_F(LogEstimatorTest, WhatALogDoesNotDetermineIsSaid) {
  WriteStanding({});
  const test::Result result = test::RunCommand(app + " flat --identify " + mcap());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  for (const char* key : {"rotor_inertia_kg_m2", "friction_N_m", "damping_N_m_s_per_rad", "payload_kg"})
    EXPECT_THAT(result.text, HasSubstr(std::string(key) + " is not determined"));
  EXPECT_THAT(result.text, HasSubstr("/joint_commands"));
  EXPECT_THAT(ReadText(out / "identify/hardware.yaml"), ::testing::Not(HasSubstr("friction_ratio")));
}

}  // namespace tenon::apps_log_estimator_test
