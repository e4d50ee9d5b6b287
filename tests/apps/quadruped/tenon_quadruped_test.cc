// The command line of tenon-quadruped, its output files and its exit codes.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/plants/model/quadruped_test_arm.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <numeric>

namespace tenon::tenon_quadruped_test {

namespace fs = std::filesystem;
using test::Column, test::Result, test::RunCommand, ::testing::AllOf, ::testing::ContainsRegex,
    ::testing::Each, ::testing::EndsWith, ::testing::HasSubstr, ::testing::Lt, ::testing::Not;

class TenonQuadrupedTest : public test::AppTest {
 protected:
  TenonQuadrupedTest() : AppTest(TENON_QUADRUPED) {}
  void ExpectNull(const std::vector<std::string>& figures) const {
    for (const std::string& figure : figures) EXPECT_THAT(Summary(), HasSubstr("\"" + figure + "\": null"));
  }
  /// Repeats the last run, with changes, and returns the figures of `name`.
  nlohmann::json Replayed(const std::string& changes = "", const std::string& name = "") const {
    const Result result = RunCommand(app + " --replay " + out.string() + changes);
    const std::string summary = ReadText(out / "replay" / name / "summary.json");
    EXPECT_FALSE(summary.empty()) << result.text;
    return nlohmann::json::parse(summary);
  }
};

TEST_F(TenonQuadrupedTest, WalksWithAllFigures) {
  const std::string text = Run("A1 --duration 1.2");
  for (const std::string key :
       {"com_error_max_m", "com_error_rms_m", "foot_error_max_m", "grf_error_mean_N", "force_estimate_mean_N",
        "force_estimate_error_rms_N", "qp_time_median_us", "qp_time_p99_us", "qp_failures"})
    EXPECT_THAT(Summary(), HasSubstr("\"" + key + "\": "));
  EXPECT_THAT(Summary(), HasSubstr("\"observer\": \"hybrid\""));
  EXPECT_THAT(text, AllOf(HasSubstrs("front_left  front_right   rear_left  rear_right\n", " N m   (at most "),
                          EndsWith((out / "report.html").string() + "\n")))
      << "the figures of the legs form a table";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100) << line;
}

TEST_F(TenonQuadrupedTest, IntegratesTheWorkAndTheRateOfTheTorques) {
  Run("A4 --duration 0.8 --set log_rate_hz=1000");
  double work = 0, squares = 0;
  std::size_t count = 0;
  for (const char* leg : {"front_left", "front_right", "rear_left", "rear_right"})
    for (const char* joint : {"abduction", "hip_pitch", "knee"}) {
      const std::string name = std::string(leg) + "_" + joint;
      const auto torque = Column(out, "loop.world.plant.joint_torque." + name + " [N m]");
      const auto speed = Column(out, "loop.world.plant.state.qd." + name + " [rad/s]");
      for (std::size_t i = 1; i < torque.size(); ++i, ++count) {
        work += 1e-3 * std::abs(torque[i] * speed[i]);
        squares += std::pow((torque[i] - torque[i - 1]) / 1e-3, 2);
      }
    }
  const auto summary = nlohmann::json::parse(Summary());
  EXPECT_NEAR(summary["joint_work_J"], work, 1e-6 * work);
  EXPECT_NEAR(summary["torque_rate_rms_Nm_per_s"], std::sqrt(squares / count), 1e-3);
}

// An arm of the robot's URDF swings, with a load on its last joint. The controller believes that it is
// locked.
TEST_F(TenonQuadrupedTest, WalksWithAnArmThatMoves) {
  const std::string gains = ", stiffness_N_m_per_rad: 200, damping_N_m_s_per_rad: 10}\n";
  Write("aliengo.urdf", test::WithArm(ReadText(TENON_ROBOTS_DIR "/aliengo.urdf")));
  const std::string robot =
      Write("aliengo.yaml", ReadText(TENON_ROBOTS_DIR "/aliengo.yaml") +
                                "actuated_joints:\n"
                                "  - {joint: arm_pitch" +
                                gains + "  - {joint: arm_elbow" + gains +
                                "  - {joint: arm_yaw, angle_rad: 0.2, amplitude_rad: 0.5, "
                                "period_s: 2" +
                                gains);
  Run("A1 --duration 1.2 --set robot=" + robot +
      " --set 'attached=[{name: load, on: arm_elbow, joint: weld, mass_kg: 0.2, radius_m: 0.05}]'");
  const std::vector<double> yaw = Column(out, "loop.world.plant.added_positions.arm_yaw [rad]");
  EXPECT_NEAR(yaw.front(), 0.2, 1e-9);
  EXPECT_GT(*std::ranges::max_element(yaw), 0.5);
  const nlohmann::json summary = nlohmann::json::parse(Summary());
  EXPECT_LT(summary.at("com_error_max_m").get<double>(), 0.005);
  EXPECT_LT(summary.at("force_estimate_error_rms_N").get<double>(), 5) << "the arm weighs 29 N";
}

TEST_F(TenonQuadrupedTest, WalksOnSimbodysDynamics) {
  const auto error = [&](const std::string& dynamics) {
    Run("A1 --duration 1 --set dynamics=" + dynamics);
    return nlohmann::json::parse(Summary()).at("com_error_max_m").get<double>();
  };
  const double closed_form = error("closed_form"), simbody = error("simbody");
  EXPECT_NE(simbody, closed_form);
  EXPECT_NEAR(simbody, closed_form, 1e-8 * closed_form);
}

// The observer leaves the known arm of 43 N to the controller.
TEST_F(TenonQuadrupedTest, WalksWithAKnownArm) {
  Run("A1-arm --duration 1.5 --set 'forces=[]' --set known_additions=true --set observer=com");
  const nlohmann::json summary = nlohmann::json::parse(Summary());
  EXPECT_LT(summary.at("force_estimate_error_rms_N").get<double>(), 3);
  EXPECT_LT(summary.at("com_error_max_m").get<double>(), 0.01);
  std::vector<double> force = Column(out, "loop.observer.wrench.force_W.z [N]");
  EXPECT_NEAR(force[force.size() / 2], 0, 5);
}

TEST_F(TenonQuadrupedTest, ComparesObservers) {
  Run("A2 --compare --duration 0.6");
  for (const char* name : {"hybrid", "focchi", "ndo_m", "ndo_inverse"})
    EXPECT_TRUE(fs::exists(out / name / "summary.json")) << name;
  EXPECT_THAT(Summary(), HasSubstrs("\"focchi\": {", "\"ndo_m\": {"));
  Run("A2 --duration 0.1");
  EXPECT_FALSE(fs::exists(out / "focchi")) << "left by the earlier run";
  EXPECT_TRUE(fs::exists(out / "report.html"));
  ExpectRefused({{"A2 --compare --set compare=[legs,legs]", "'legs'"}});
}

// The settling time of first order and the overshoot of second order, exp(-pi zeta / sqrt(1 - zeta^2)) with
// zeta = sqrt(1/2), have closed forms.
TEST_F(TenonQuadrupedTest, JudgesTheEstimateOfAForceOnAFoot) {
  const auto figure = [&](int order, double bandwidth, const char* key) {
    Run(
        fmt::format("A0 --duration 0.6 --set 'profile={{file: standard, observer: {{legs: {{gains_per_s: [], "
                    "butterworth: {{order: {}, bandwidth_rad_per_s: {}}}}}}}}}'",
                    order, bandwidth));
    return nlohmann::json::parse(Summary()).at(key).get<double>();
  };
  EXPECT_NEAR(figure(1, 100, "force_settling_time_s"), std::log(50) / 100, 1.5e-3);
  EXPECT_LT(figure(1, 100, "force_overshoot_ratio"), 4e-3);
  EXPECT_NEAR(figure(2, 141.421, "force_overshoot_ratio"), std::exp(-M_PI), 4e-3);
  Run("A0 --duration 0.1");
  ExpectNull({"force_settling_time_s", "force_overshoot_ratio"});
  ExpectRefused({{"A0 --set 'profile={file: standard, observer: {legs: {gains_per_s: [17.5, 6.28, 2.25]}}}'",
                  "profile.observer.legs"}});
}

TEST_F(TenonQuadrupedTest, ATerminalShowsWhichOfSeveralRunsIsGoing) {
  // script(1) runs the app in a terminal.
  const Result result =
      RunCommand("script -qec '" + app + " A2 --compare --duration 0.05" + Out() + "' /dev/null");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("run 2 of 5: 0.1/0.1 s"));
}

TEST_F(TenonQuadrupedTest, TakesGaitSpeedAndObserver) {
  Run("flat --gait pace --speed 0.1 --observer none --duration 0.1");
  EXPECT_THAT(ReadText(out / "scenario.yaml"),
              HasSubstrs("gait: pace\n        forward_m_per_s: 0.1", "observer: none"));
  ExpectRefused({{"stand --gait trot", "--gait"}, {"flat --gait canter", "gallop"}});
}

TEST_F(TenonQuadrupedTest, ServesAStandingRobotInRealTime) {
  const std::string text = "stand --duration 0.1 --serve unitree";
  if (!TENON_WITH_UNITREE) return ExpectRefused({{text, "cyclonedds-dev"}});
  // A domain that tests running at the same time do not share.
  Run(text + fmt::format(":lo,{}", 100 + getpid() % 100));
  const nlohmann::json summary = nlohmann::json::parse(Summary());
  EXPECT_EQ(summary.at("robot"), "go2");
  EXPECT_EQ(summary.at("commands"), 0);
  EXPECT_GE(summary.at("wall_s").get<double>(), 0.09);
  EXPECT_NEAR(summary.at("height_end_m").get<double>(), summary.at("height_min_m").get<double>(), 0.01);
  EXPECT_EQ(Replayed().at("messages_equal"), 101);
  ExpectRefused({{"A1 --serve unitree", "'A1' walks"},
                 {"stand --serve spot", "unitree:eth0,0"},
                 {"stand --serve unitree:lo,x", "INTERFACE,DOMAIN"},
                 {"stand --serve unitree:nix0", "'nix0'"},
                 {"stand --serve unitree:lo,300", "domain = 300"},
                 {"stand --drive unitree", "'stand' stands"},
                 {"flat --drive unitree:lo,300", "domain = 300"},
                 {"flat --compare --drive unitree:lo", "--compare"},
                 {"stand --serve unitree:lo --set robot.link.unitree=eth0", "robot.link"}});
}

// Without a robot, its state is the initial one, and the supervisor damps the joints after the timeout.
TEST_F(TenonQuadrupedTest, ADrivenRunIsRepeatedWithEqualChecksums) {
  if (!TENON_WITH_UNITREE) return;
  const int domain = 100 + getpid() % 100;
  EXPECT_THAT(Run(fmt::format("pushed --duration 0.3 --set robot.link.unitree=lo,{}", domain)),
              HasSubstrs("driving the robot", "built-in mode"));
  EXPECT_THAT(Run(fmt::format("pushed --duration 0.3 --drive unitree:lo,{}", domain)),
              HasSubstr("driving the robot"));
  EXPECT_THAT(ReadText(out / "scenario.yaml"),
              HasSubstrs(fmt::format("unitree: \"lo,{}\"", domain), "hardware: standard"));
  const nlohmann::json same = Replayed();
  EXPECT_EQ(same.at("messages_equal"), 151);
  EXPECT_EQ(same.at("messages_different"), 0);
  EXPECT_EQ(same.at("mode"), nlohmann::json::parse(Summary()).at("mode"));
  EXPECT_GT(Replayed(" --set deployment.initial=walk", "changed").at("messages_different"), 100);
  EXPECT_EQ(nlohmann::json::parse(ReadText(out / "replay/recorded/summary.json")).at("messages_different"),
            0);
  std::filesystem::resize_file(out / "wire.bin", std::filesystem::file_size(out / "wire.bin") - 5);
  EXPECT_EQ(Replayed().at("messages_equal"), 150) << "the last row is not whole";
  Write("wire.bin", "tenon wire 1: time\n");
  const test::Result refused = test::RunCommand(app + " --replay " + out.string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.text, HasSubstrs("wire.bin", "1 columns"));
}

TEST_F(TenonQuadrupedTest, ADrivenRunThatIsKilledIsRepeatedAsFarAsItWent) {
  if (!TENON_WITH_UNITREE) return;
  const Result result = RunCommand(fmt::format(
      "bash -c '{} pushed --drive unitree:lo,{} --set deployment.initial=walk --set "
      "deployment.limits.timeout_s=1 --set \"deployment.goals=[{{start_s: 0, goal: walk}}]\" {} & run=$!; "
      "until "
      "[ $(stat -c %s {} 2>/dev/null || echo 0) -gt 200000 ]; do kill -0 $run || exit 99; sleep 0.02; done; "
      "kill -KILL $run; wait $run'",
      app, 100 + getpid() % 100, Out(), (out / "wire.bin").string()));
  EXPECT_EQ(result.exit_code, 137) << result.text;
  const nlohmann::json same = Replayed();
  EXPECT_GT(same.at("messages_equal"), 300);
  EXPECT_EQ(same.at("messages_different"), 0);
  EXPECT_THAT(Column(out / "replay", "loop.locomotion.mpc.age [s]"),
              ::testing::Contains(::testing::Gt(0.007)));
}

TEST_F(TenonQuadrupedTest, ARunIsRepeatedFromItsDirectory) {
  Run("stand --duration 0.2");
  const std::string command = app + " --replay " + out.string();
  const test::Result replay = test::RunCommand(command);
  EXPECT_EQ(replay.exit_code, 0) << replay.text;
  EXPECT_THAT(replay.text, ContainsRegex("signals.csv +equal"));
  Write("signals.csv", Signals() + "0,0\n");
  EXPECT_THAT(test::RunCommand(command).text, ContainsRegex("signals.csv +DIFFERENT"));
  EXPECT_THAT(test::RunCommand(command + " --seed 3").text, HasSubstr("--replay DIRECTORY"));
  EXPECT_THAT(test::RunCommand(command + Out()).text, HasSubstr("holds the run"));
}

TEST_F(TenonQuadrupedTest, DampsTheJointsWithin20MillisecondsOfALostLinkAndAtTheButton) {
  const auto expect = [&](const std::string& fault, double most) {
    const nlohmann::json summary = nlohmann::json::parse(Summary());
    EXPECT_EQ(summary.at("mode"), "damp");
    EXPECT_EQ(summary.at("fault"), fault);
    EXPECT_GE(summary.at("damped_at_s").get<double>(), 0.1);
    EXPECT_LE(summary.at("damped_at_s").get<double>(), 0.1 + most);
    // Damping takes power from each joint, up to the rounding of a tick.
    const std::vector<double> time = Column(out, "time [s]");
    for (const std::string joint : {"front_left_hip_pitch", "rear_right_knee"}) {
      const std::vector<double> torque = Column(out, "loop.drives.torque." + joint + " [N m]");
      const std::vector<double> speed = Column(out, "loop.world.plant.state.qd." + joint + " [rad/s]");
      for (std::size_t i = 0; i < time.size(); ++i)
        if (time[i] > 0.13) EXPECT_LT(torque[i] * speed[i], 0.5) << joint << " at " << time[i];
    }
  };
  Run("lost_link --duration 0.3 --set faults.0.start_s=0.1 --set faults.1.start_s=0.1 --set "
      "faults.2.start_s=0.1");
  expect("lost", 0.02);
  Run("stop_button --duration 0.3 --set deployment.goals.1.start_s=0.1");
  expect("stop", 0.001);
  ExpectRefused({{"stand --set 'deployment={}'", "deployment"},
                 {"flat --set 'faults=[{at: link, kind: stuck}]'", "faults.0.at"}});
}

TEST_F(TenonQuadrupedTest, FiguresWithoutDataAreNull) {
  Run("A1 --duration 0.2");  // the robot still stands
  EXPECT_THAT(Summary(), HasSubstr("\"com_error_max_m\": 0."));
  ExpectNull({"front_left"});
  EXPECT_THAT(Run("A1 --duration 0.2 --set walk.judged_from_s=2"),
              HasSubstrs("warning: ", "walk.judged_from_s = 2 s"));
  ExpectNull({"com_error_max_m", "com_error_rms_m", "grf_error_mean_N", "force_estimate_error_rms_N",
              "qp_time_median_us", "qp_failures", "distance_m"});
  Run("flat --duration 0.2 --set start_height_m=2");  // all feet search for the ground, none swings
  EXPECT_THAT(Summary(), HasSubstr("\"foot_error_max_m\": {\n    \"front_left\": null"));
  ExpectNull({"foot_depth_max_m"});
  Run("A1 --observer none --duration 0.1");
  EXPECT_THAT(Summary(), HasSubstr("\"force_estimate_mean_N\": {\n    \"x\": null"));
  ExpectNull({"force_estimate_error_rms_N"});
  Run("stand --duration 0.02 --set start_height_m=0.05");
  ExpectNull({"foot_force_max_N"});
}

TEST_F(TenonQuadrupedTest, LandsOnItsFeetAndWalks) {
  Run("flat --duration 1.5 --set start_height_m=0.1");
  Run("drop --duration 1 --set robot=a1");
}

TEST_F(TenonQuadrupedTest, WalksByPredictiveControl) {
  Run("pushed --duration 1");
  EXPECT_THAT(ReadText(out / "signals.csv"), HasSubstr("loop.locomotion.body"));
  EXPECT_THAT(Summary(), HasSubstrs("\"mpc_time_median_us\": ", "\"mpc_failures\": 0"));
  const std::string slow = " --set 'hardware={file: ideal, calculation: {time_s: 0.004}}' --duration 0.1";
  Run("pushed" + slow);
  EXPECT_THAT(test::Column(out, "loop.locomotion.mpc.age [s]"), Each(Lt(0.015)));
  ExpectRefused({{"A1" + slow, "predictive control"}});
  ExpectRefused({{"pushed --set walk.mpc.step_s=0.025", "walk.mpc"},
                 {"pushed --set walk.mpc.num_steps=1", "num_steps"}});
}

TEST_F(TenonQuadrupedTest, RefusesMoreThan100Faults) {
  std::string faults = "extends: stand\nfaults:\n";
  for (int i = 0; i < 101; ++i) faults += "  - {at: torque, kind: offset, size: 0}\n";
  ExpectRefused({{Write("faults.yaml", faults), "faults.yaml:3:3: faults: "}});
}

TEST_F(TenonQuadrupedTest, ScenariosExtendEachOther) {
  Run(Write("own.yaml", "extends: A4-noisy\ncase: own\nseed: 9\n") + " --duration 0.1");
  EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstrs("case: own", "noise_ratio: 0.1", "upper_N: 35"));
}

// The URDF lies in another directory than the robot's YAML. The run copies both, so that its directory can be
// moved.
TEST_F(TenonQuadrupedTest, WrittenScenarioHasTheRobotsUrdf) {
  const fs::path home = out.string() + "_home", robots = TENON_ROBOTS_DIR;
  std::string robot = ReadText(robots / "dogbot.yaml");
  Write("robots/dog.yaml", robot.replace(robot.find("dogbot.urdf"), 11, "bodies/dog.urdf"));
  Write("robots/bodies/dog.urdf", ReadText(robots / "dogbot.urdf"));
  Run(Write("own.yaml", "extends: stand\nrobot: robots/dog.yaml\nduration_s: 0.05\n") +
      " --set robot.foot_radius_m=0.03");
  EXPECT_THAT(ReadText(out / "scenario.yaml"),
              HasSubstrs("files/robot.yaml", "foot_radius_m: 0.03", "format: 1"));
  EXPECT_THAT(Summary(), HasSubstr("dog.yaml, changed"));
  const std::string first = Signals();
  fs::rename(out, home);
  fs::remove_all(home / "robots");
  Run((home / "scenario.yaml").string());
  EXPECT_EQ(Signals(), first);
  fs::remove_all(home);
}

// The seed determines times, durations and directions of the pushes.
TEST_F(TenonQuadrupedTest, PushesAreDrawnBySeed) {
  const auto pushes = [&](int seed) {
    Run("random_pushes --duration 0.05 --seed " + std::to_string(seed));
    const std::string scenario = ReadText(out / "scenario.yaml");
    return scenario.substr(scenario.find("forces:"), 600);
  };
  const std::string one = pushes(1);
  EXPECT_THAT(one, AllOf(HasSubstr("turn_rad"), Not(HasSubstr("uniform"))));
  EXPECT_EQ(pushes(1), one);
  EXPECT_NE(pushes(2), one);
}

TEST_F(TenonQuadrupedTest, WalksWithTheHardwareOfARobot) {
  for (const std::string hardware : {"standard", "rough"}) {
    Run("A4 --duration 0.3 --set walk.state=estimated --set hardware=" + hardware);
    EXPECT_THAT(Summary(), HasSubstrs("\"path_error_max_m\": 0.0", "\"drift_m\": 0.0"));
  }
}

// On a robot at rest a sensor outputs its bias plus noise, which changes at the rate of the sensor.
TEST_F(TenonQuadrupedTest, SensorsHaveBiasNoiseAndRateOfTheirOwn) {
  Run("stand --duration 0.2 --set 'sensors={encoders: {speed_bias_rad_per_s: 0.5}, "
      "torque: {rate_hz: 100, noise_ratio: 0.1}, foot_force: {rate_hz: 50, noise_ratio: 0.1, bias_N: 20}, "
      "imu: {rate_hz: 20, angular_velocity_bias_rad_per_s: [0.1, 0.2, 0.3], "
      "angular_velocity_noise_rad_per_s: 1e-4}}'");
  const auto changes = [&](const std::string& name) {
    std::vector<double> values = Column(out, name);
    return std::unique(values.begin(), values.end()) - values.begin() - 1;
  };
  EXPECT_EQ(changes("loop.world.torque_sensor.measured.front_left_knee [N m]"), 20);
  EXPECT_EQ(changes("loop.world.foot_sensor.measured.front_left.z [N]"), 10);
  EXPECT_EQ(changes("loop.world.imu.measurement.angular_velocity_B.z [rad/s]"), 4);
  EXPECT_NEAR(Column(out, "loop.world.encoders.joints.qd.front_left_knee [rad/s]").back() -
                  Column(out, "loop.world.plant.state.qd.front_left_knee [rad/s]").back(),
              0.5, 1e-6);
  EXPECT_NEAR(Column(out, "loop.world.imu.measurement.angular_velocity_B.z [rad/s]").back() -
                  Column(out, "loop.world.plant.state.w_W.z [rad/s]").back(),
              0.3, 1e-3);
  EXPECT_NEAR(Column(out, "loop.world.foot_sensor.measured.front_left.y [N]").back(), 20, 5);
}

TEST_F(TenonQuadrupedTest, AFallIsExitCode3AndSaysWhy) {
  Run("stand --duration 4 --set 'forces=[{force_N: [0, 400, 0], duration_s: 2}]'", 3);
  EXPECT_THAT(Summary(), HasSubstrs("\"fell\": true", "the robot fell: its trunk is"));
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("the robot fell: its trunk is"));
}

// Torques beyond the drives and bodies in the ground do not end a run: the verdict names them.
TEST_F(TenonQuadrupedTest, ARunThatNoRobotPerformsIsNotFinished) {
  // Contacts that are too soft for the weight of the robot, and for its fall.
  const std::string stand = "stand --set fall.min_height_ratio=0 --set fall.max_tilt_rad=3 ";
  for (const auto& [run, reason] : {
           std::pair<std::string, std::string>{"flat --duration 1.5 --set limit_speed=false",
                                               "a drive exceeded its torque-speed line: "},
           {stand + "--duration 0.2 --set robot.contact.stiffness_N_per_m=2000",
            "a foot went into the ground: "},
           {"stop_button --set robot.contact.stiffness_N_per_m=8000 --duration 3.1",
            "trunk, hip or knee went into the ground: "},
       }) {
    Run(run, 3);
    EXPECT_THAT(Summary(), HasSubstrs("\"finished\": false", "\"fell\": false", reason));
    EXPECT_NE(ReadText(out / "report.html").find("but " + reason), std::string::npos);
  }
}

TEST_F(TenonQuadrupedTest, StandsOnASlopeUnderAPayloadAndASine) {
  Run("stand --duration 2 --set 'terrain={grade: [0.1, 0.1]}' --set payload.mass_kg=5 --set "
      "'forces=[{on: front_left, force_N: [20, 0, 0], duration_s: 2, frequency_rad_per_s: 1}]'");
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("slope"));
}

TEST_F(TenonQuadrupedTest, WalksByTheStateEstimator) {
  Run("flat --duration 1 --set walk.state=estimated");
  EXPECT_THAT(Summary(), HasSubstrs("\"velocity_estimate_error_rms_m_per_s\": 0.00",
                                    "\"tilt_estimate_error_max_rad\": 0.00"));
  Run("flat --duration 0.1");
  EXPECT_THAT(Summary(), Not(HasSubstr("velocity_estimate")));
}

// The controller knows neither the sliding load nor the errors of its model.
TEST_F(TenonQuadrupedTest, WalksWithASlidingLoadAndWrongData) {
  const auto knees = [&] { return Column(out, "loop.world.plant.state.q.front_left_knee [rad]"); };
  Run("flat --duration 1.5 --set 'payload={mass_kg: 5, position_m: [0, 0, 0.12], slides: {friction: 0.2}}' "
      "--set 'walk.model_error={mass_ratio: 0.2, com_ratio: 0.05, inertia_ratio: 0.3, length_ratio: 0.02}'");
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("sliding load"));
  EXPECT_THAT(Summary(), HasSubstr("\"com_error_max_m\": 0.0"));
  const std::vector<double> with_errors = knees();
  Run("flat --duration 1.5");
  EXPECT_NE(knees(), with_errors);
}

// The observer's mean vertical force is the weight of the arm, which the controller does not know.
TEST_F(TenonQuadrupedTest, WalksWithASwingingArm) {
  Run("A1-arm --duration 4 --set 'forces=[]' --set observer=com --set walk.judged_from_s=2");
  EXPECT_THAT(Summary(), Not(HasSubstr("\"force_estimate_error_rms_N\": null")));
  const std::vector<double> shoulder = Column(out, "loop.world.plant.added_positions.upper_arm [rad]");
  EXPECT_GT(*std::max_element(shoulder.begin(), shoulder.end()), 1);
  const std::vector<double> force = Column(out, "loop.observer.wrench.force_W.z [N]");
  const auto half = force.begin() + static_cast<std::ptrdiff_t>(force.size() / 2);
  const double mean = std::accumulate(half, force.end(), 0.0) / static_cast<double>(force.end() - half);
  EXPECT_NEAR(mean, -4.418 * 9.81, 8);
}

TEST_F(TenonQuadrupedTest, WalksUpASlopeOnRopes) {
  Run("E1 --duration 2");
  for (const char* name : {"left", "right"}) {
    const std::vector<double> tension = Column(out, fmt::format("loop.ropes.tension.{} [N]", name));
    const auto [least, most] = std::minmax_element(tension.begin(), tension.end());
    EXPECT_GT(*least, 10);
    EXPECT_LT(*most, 250);
  }
}

// The reference begins where the robot stands, although the estimated ground is that below its feet, up the
// slope.
TEST_F(TenonQuadrupedTest, StartsOnItsReferenceOnASlope) {
  Run("E1 --duration 0.02 --set log_rate_hz=1000");
  EXPECT_LT(std::abs(Column(out, "loop.errors.errors.com.z [m]")[0]), 2e-3);
}

TEST_F(TenonQuadrupedTest, WalksDownAndAcrossASlopeOnRopes) {
  for (const char* scenario : {"E2-down", "E2-side", "E3"}) {
    Run(fmt::format("{} --duration 1.5", scenario));
  }
}

// It walks over level ground beside the kerb, and stops before the end of its path.
TEST_F(TenonQuadrupedTest, AWalkIsFinishedIfItsTaskWasDone) {
  const std::string shorter =
      " --set 'walk.path.segments=[{gait: trot, forward_m_per_s: 0.3, length_m: 0.3}]' --duration 1.4";
  Run("kerb" + shorter, 3);
  EXPECT_THAT(Summary(), HasSubstr("the task was not done: climb_m is 0, but must be at least 0.09"));
  Run("kerb --set task.figures.climb_m.at_least=null" + shorter);
  Run("flat" + shorter + " --set task.figures.distanc_m.at_least=1", 2);
  const std::string broken =
      "E4 --set 'walk.path.segments=[{gait: trot, forward_m_per_s: 0.12, length_m: "
      "0.2}]' --duration 2.5 --set faults.0.start_s=0.2 --set walk.path_tolerance=0.3";
  Run(broken);
  Run(broken + " --set task.arrives=true", 3);
  EXPECT_THAT(Summary(), HasSubstr("distance_m is "));
}

// It stops after the loss, where it is, and the other rope carries it.
TEST_F(TenonQuadrupedTest, StaysOnTheSlopeIfARopeBreaks) {
  Run("E4 --duration 4 --set faults.0.start_s=1");
  EXPECT_EQ(Column(out, "loop.ropes.tension.left [N]").back(), 0);
  EXPECT_GT(Column(out, "loop.ropes.tension.right [N]").back(), 100);
  const std::vector<double> gait = Column(out, "loop.locomotion.schedule.gait");
  EXPECT_EQ(gait[gait.size() / 4], 2) << "trot";
  EXPECT_EQ(gait.back(), 0) << "stand";
  const std::vector<double> x = Column(out, "loop.world.plant.state.p_WB.x [m]");
  EXPECT_NEAR(x[x.size() / 2], x.back(), 2e-3);
}

TEST_F(TenonQuadrupedTest, LandsOnItsFeetFromItsRopes) {
  Run("E5 --duration 0.6");
  EXPECT_GT(Column(out, "loop.ropes.tension.rear_left [N]").front(), 50);
  EXPECT_LT(Column(out, "loop.ropes.tension.rear_left [N]").back(), 5);
  EXPECT_EQ(Column(out, "loop.locomotion.schedule.legs.front_left.state").back(), 0) << "stance";
}

// One of each kind: in a file that the scenario names, beside it, of a range, a type or a name, found when
// the diagram is made.
TEST_F(TenonQuadrupedTest, RefusesBadSettings) {
  ExpectSettingsRefused("stand", {"robot.foot_radius_m=-1", "hardware=perfect", "hardware.link.delay_s=1.5",
                                  "start_height_m=-0.1", "fall.max_height_m=0.01", "live.yaw_rad_per_s=[1,2]",
                                  "sensors.torque.noise_ratio=-1", "sensors.encoders.rate_hz=1e-30",
                                  "integrator.atol_position=1e308", "payload.position_m=[0,-1e308,0]"});
  ExpectSettingsRefused("flat", {"walk.gaits.trot=1", "walk.state=guessed", "walk.zmp.horizon_steps=9",
                                 "profile.qp_rate_hz=-1"});
}

// The message names the key of the list or map that is wrong, or the one that contradicts another.
TEST_F(TenonQuadrupedTest, RefusesSettingsThatDoNotFitTogether) {
  ExpectRefused(
      {{Write("none.yaml", "app: tenon-quadruped\ncase: none\n"), "none.yaml:1:1: "},
       {Write("sweep.yaml", "extends: flat\nsweep: {period_s: 1}\n"), "sweep.yaml:2:1: sweep was renamed"},
       {"A1 --set walk.judged_from_s=1000", "walk.judged_from_s"},
       {"stand --set pd.stiffness_N_m_per_rad=0", "stand.yaml:9:3: pd: block 'loop': block 'pd': "},
       {"stand --set integrator.method=stabilized --set integrator.order=4", ": integrator.order: "},
       {"flat --set 'profile.observer.legs.butterworth={order: 3, bandwidth_rad_per_s: 100}'",
        ": profile.observer.legs: observer.legs.gains_per_s: "},
       {"stand --set 'payload={mass_kg: 1, position_m: [0, 0, -1.5]}'", ": payload.position_m: "},
       {"stand --set 'forces=[{on: tail, duration_s: 1}]'", ": forces.0.on: "},
       {"stand --set \"forces=[$(printf '{duration_s: 1},%.0s' 1 2 3 4 5 6 7 8){duration_s: 1}]\"",
        ": forces: "},
       {"stand --set 'random_forces=[{lower_N: 3, upper_N: 2}]'", ": random_forces.0.upper_N: "},
       {"flat --set terrain.grade=[50,0]", ": terrain: "},
       {"E1 --set ropes.0.tension_min_N=1e3", ": ropes.0.tension_min_N: "},
       {"E1 --set ropes.1.name=left", ": ropes: "},
       {"E1 --set 'faults=[{at: rope, kind: broken, duration_s: 1}]'", ": faults.0.at: "},
       {"flat --set 'faults=[{at: rope, kind: broken}]'", ": faults.0.at: "},
       {Write("coincide.yaml",
              "extends: flat\nropes: [{name: a, anchor_m: [0, 0, 0.430153], attachment_m: [0, 0, 0], "
              "tension_max_N: 9}]\n"),
        "coincide.yaml:2:8: ropes: "},
       {"stand --set 'ropes=[{name: a, anchor_m: [9, 0, 9], attachment_m: [0, 0, 0], tension_max_N: 9}]'",
        ": ropes: "},
       {"stand --set 'report.plots=[{title: a, signals: [b]}]'",
        ": report.plots.0.signals.0: the diagram has no port 'b'"},
       {"stand --set 'log.signals=[\"\\e[31m\"]'", ": log.signals.0: the diagram has no port '\\x1b[31m'"},
       {"stand --set report.plots.1.signals=[]", "stand.yaml:13:3: report: the plot 'attitude"},
       {"flat --duration 1 --set walk.path.segments.1.length_m=1e-4",
        "flat.yaml:11:9: walk.path.segments.1: "}});
}

}  // namespace tenon::tenon_quadruped_test
