// Runs the binary as its users do.

#include <tenon/tests/apps/run_app.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <vector>

namespace tenon::tenon_quadruped_test {
namespace {

namespace fs = std::filesystem;
using test::BadUsage;
using test::Column;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_QUADRUPED) + " " + arguments);
}

using TenonQuadrupedTest = test::AppTest;

TEST_F(TenonQuadrupedTest, WritesSummarySignalsScenarioAndGraph) {
  const Result result = RunApp("stand --duration 0.2 --seed 7" + Out() + " --graph " + out.string() + ".dot");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"case", "seed", "finished", "fell", "end_reason", "simulated_s", "wall_s",
                          "real_time_factor", "robot", "height_min_m", "height_end_m", "drift_m",
                          "tilt_max_rad", "torque_max_N_m", "foot_force_max_N", "evaluations"}) {
    EXPECT_THAT(summary, HasSubstr("\"" + std::string(key) + "\": "));
  }
  EXPECT_THAT(summary, AllOf(HasSubstr("\"seed\": 7"), HasSubstr("\"finished\": true"),
                             HasSubstr("\"robot\": \"dogbot\""), HasSubstr("\"simulated_s\": 0.2")));
  EXPECT_THAT(Read(out / "signals.csv"),
              AllOf(HasSubstr("time [s],"), HasSubstr("loop.world.plant.foot_forces.front_left.z [N]"),
                    HasSubstr("loop.world.imu.measurement.specific_force_B.z [m/s^2]"), HasSubstr("\n0.2,")));
  EXPECT_THAT(Read(out / "scenario.yaml"), AllOf(HasSubstr("case: stand"), HasSubstr("atol_bristles")));
  EXPECT_THAT(Read(out.string() + ".dot"), AllOf(HasSubstr("cluster_loop"), HasSubstr("encoders")));
  EXPECT_THAT(Read(out / "report.html").substr(0, 500), HasSubstr("<title>stand: holds its stance"));
  fs::remove(out.string() + ".dot");
}

TEST_F(TenonQuadrupedTest, WalksWithAllFigures) {
  const Result result = RunApp("A1 --duration 1.2" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"observer", "com_error_max_m", "com_error_rms_m", "foot_error_max_m",
                          "grf_error_mean_N", "force_estimate_mean_N", "force_estimate_error_rms_N",
                          "qp_time_median_us", "qp_time_p99_us", "qp_failures"})
    EXPECT_THAT(summary, HasSubstr("\"" + std::string(key) + "\": "));
  EXPECT_THAT(summary, AllOf(HasSubstr("\"case\": \"A1\""), HasSubstr("\"observer\": \"hybrid\"")));
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("front_left  front_right   rear_left  rear_right\n"),
                    HasSubstr(" N m   (at most "), EndsWith((out / "report.html").string() + "\n")))
      << "legs are a table";
  for (std::size_t begin = 0, end; (end = result.text.find('\n', begin)) != std::string::npos;
       begin = end + 1)
    EXPECT_LE(end - begin, 100) << result.text.substr(begin, end - begin);
}

TEST_F(TenonQuadrupedTest, ComparesObserversAndSweepsPhases) {
  EXPECT_EQ(RunApp("A2 --compare --duration 0.6" + Out()).exit_code, 0);
  for (const char* name : {"hybrid", "focchi", "ndo_m", "ndo_inverse"})
    EXPECT_TRUE(fs::exists(out / name / "summary.json")) << name;
  EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"focchi\": {"), HasSubstr("\"ndo_m\": {")));
  EXPECT_EQ(RunApp("A3-sweep --duration 0.1 --set sweep.phases=2 --set sweep.directions=1" + Out()).exit_code,
            0);
  EXPECT_THAT(Read(out / "phase_1_direction_0" / "scenario.yaml"), HasSubstr("start_s: 3.885"));
  EXPECT_FALSE(fs::exists(out / "focchi")) << "of the run before";
  EXPECT_TRUE(fs::exists(out / "report.html"));
}

TEST_F(TenonQuadrupedTest, ATerminalIsToldWhichOfSeveralRunsGoes) {
  const std::string command = std::string(TENON_QUADRUPED) + " A2 --compare --duration 0.05" + Out();
  const Result result = RunCommand("script -qec '" + command + "' /dev/null");  // a terminal
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("run 2 of 4: 0.1/0.1 s"));
}

TEST_F(TenonQuadrupedTest, GaitSpeedAndObserverAreForThoseWhoWalk) {
  EXPECT_EQ(RunApp("flat --gait pace --speed 0.1 --observer none --duration 0.1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "scenario.yaml"),
              AllOf(HasSubstr("gait: pace\n        forward_m_per_s: 0.1"), HasSubstr("observer: none")));
  const Result stands = RunApp("stand --gait trot" + Out());
  EXPECT_EQ(stands.exit_code, 2);
  EXPECT_THAT(stands.text, HasSubstr("'stand' does not walk: leave --gait"));
  const Result gallops = RunApp("flat --gait canter" + Out());
  EXPECT_EQ(gallops.exit_code, 2);
  EXPECT_THAT(gallops.text, HasSubstr("gallop"));
}

TEST_F(TenonQuadrupedTest, FiguresOfNothingAreNull) {
  ASSERT_EQ(RunApp("A1 --duration 0.2" + Out()).exit_code, 0);  // it stands yet
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"front_left\": null"), HasSubstr("\"com_error_max_m\": 0.")));
  const Result cut = RunApp("A1 --duration 0.2 --set walk.judged_from_s=2" + Out());
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_THAT(cut.text, HasSubstr("warning: the run ends at 0.2 s, before walk.judged_from_s = 2 s"));
  for (const char* key : {"com_error_max_m", "com_error_rms_m", "grf_error_mean_N",
                          "force_estimate_error_rms_N", "qp_time_median_us", "qp_failures", "distance_m"})
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"" + std::string(key) + "\": null"));
  const Result air =
      RunApp("flat --duration 0.2 --set start_height_m=2" + Out());  // feet search, none swings
  EXPECT_EQ(air.exit_code, 0) << air.text;
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"foot_error_max_m\": {\n    \"front_left\": null"),
                    HasSubstr("\"foot_depth_max_m\": null")));
  ASSERT_EQ(RunApp("A1 --observer none --duration 0.1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"force_estimate_mean_N\": {\n    \"x\": null"),
                                                HasSubstr("\"force_estimate_error_rms_N\": null")));
  ASSERT_EQ(RunApp("stand --duration 0.02 --set start_height_m=0.05" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"foot_force_max_N\": null"));
  const Result late = RunApp("A1 --set walk.judged_from_s=1000" + Out());
  EXPECT_EQ(late.exit_code, 2);
  EXPECT_THAT(late.text, HasSubstr("before walk.judged_from_s = 1000 s: lower that, or lengthen the walk"));
}

TEST_F(TenonQuadrupedTest, RefusesMoreFaultsThanARobotMayHave) {
  fs::create_directories(out);
  std::ofstream file(out / "faults.yaml");
  file << "extends: stand\nfaults:\n";
  for (int i = 0; i < 101; ++i) file << "  - {at: torque, kind: offset, size: 0}\n";
  file.close();
  const Result result = RunApp((out / "faults.yaml").string() + Out());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("faults.yaml:3:3: faults: 101 faults are too many, 100 the most")));
}

TEST_F(TenonQuadrupedTest, ScenariosExtendEachOther) {
  fs::create_directories(out);
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(out / name) << text;
    return (out / name).string();
  };
  const std::string own = write("own.yaml", "extends: A4-noisy\ncase: own\nseed: 9\n");
  EXPECT_EQ(RunApp(own + " --duration 0.1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "scenario.yaml"),
              AllOf(HasSubstr("case: own"), HasSubstr("noise_ratio: 0.1"), HasSubstr("upper_N: 35")));
  const std::string ring = write("ring.yaml", "extends: " + (out / "ring.yaml").string() + "\n");
  const Result result = RunApp(ring + Out());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.text, HasSubstr("extends itself"));
}

// A robot whose URDF lies in a directory of its own, named from below: both are copied, and start elsewhere.
TEST_F(TenonQuadrupedTest, WrittenScenarioHasTheRobotsUrdf) {
  const fs::path home = out.string() + "_home";
  fs::create_directories(home / "robots/bodies");
  std::string robot = Read(std::string(TENON_ROBOTS_DIR) + "/dogbot.yaml");
  robot.replace(robot.find("dogbot.urdf"), 11, "bodies/dog.urdf");
  std::ofstream(home / "robots/dog.yaml") << robot;
  fs::copy_file(std::string(TENON_ROBOTS_DIR) + "/dogbot.urdf", home / "robots/bodies/dog.urdf");
  std::ofstream(home / "own.yaml") << "extends: stand\nrobot: robots/dog.yaml\nduration_s: 0.05\n";
  ASSERT_EQ(RunApp((home / "own.yaml").string() + Out()).exit_code, 0);
  const std::string first = Read(out / "signals.csv");
  fs::remove_all(home);
  fs::rename(out, home);
  const Result again = RunCommand("cd / && " TENON_QUADRUPED " " + (home / "scenario.yaml").string() + Out());
  EXPECT_EQ(again.exit_code, 0) << again.text;
  EXPECT_EQ(Read(out / "signals.csv"), first);
  fs::remove_all(home);
}

// Pushes that start, last and point as chance has it; the seed repeats them.
TEST_F(TenonQuadrupedTest, PushesAreDrawnBySeed) {
  const auto pushes = [&](int seed) {
    EXPECT_EQ(RunApp("random_pushes --duration 0.05 --seed " + std::to_string(seed) + Out()).exit_code, 0);
    const std::string scenario = Read(out / "scenario.yaml");
    return scenario.substr(scenario.find("forces:"), 600);
  };
  const std::string one = pushes(1);
  EXPECT_THAT(one, AllOf(HasSubstr("turn_rad"), ::testing::Not(HasSubstr("uniform"))));
  EXPECT_EQ(pushes(1), one);
  EXPECT_NE(pushes(2), one);
}

TEST_F(TenonQuadrupedTest, RefusesScenariosThatNeitherStandNorWalk) {
  fs::create_directories(out);
  std::ofstream(out / "none.yaml") << "app: tenon-quadruped\ncase: none\n";
  EXPECT_THAT(RunApp((out / "none.yaml").string() + Out()).text,
              HasSubstr("give one of pd and walk, not none"));
  std::ofstream(out / "sweep.yaml") << "extends: flat\nsweep: {period_s: 1}\n";
  EXPECT_THAT(RunApp((out / "sweep.yaml").string() + Out()).text,
              HasSubstr("a sweep needs a walk and a force"));
  EXPECT_THAT(RunApp("A3-sweep --set sweep.phases=0" + Out()).text, HasSubstr("all must be positive"));
}

TEST_F(TenonQuadrupedTest, DropsBothRobots) {
  for (const char* robot : {"dogbot", "a1"}) {
    const Result result = RunApp("drop --duration 1 --set robot=" + std::string(robot) + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"finished\": true"));
  }
}

TEST_F(TenonQuadrupedTest, WrittenScenarioRepeatsTheRun) {
  ASSERT_EQ(RunApp("stand --duration 0.2 --set sensors.encoders.angle_noise_rad=1e-4 --set "
                   "'random_forces=[{lower_N: 10, upper_N: 35, period_s: 0.1}]'" +
                   Out())
                .exit_code,
            0);
  const std::string first = Read(out / "signals.csv");
  const Result again = RunApp((out / "scenario.yaml").string() + Out() + "/again");
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_EQ(Read(out / "again" / "signals.csv"), first);
}

TEST_F(TenonQuadrupedTest, WalksWithTheHardwareOfARobot) {
  for (const char* hardware : {"standard", "rough"}) {
    const Result result = RunApp(
        "A4 --duration 0.3 --set walk.state=estimated --set hardware=" + std::string(hardware) + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(Read(out / "summary.json"),
                AllOf(HasSubstr("\"path_error_max_m\": 0.0"), HasSubstr("\"drift_m\": 0.0")));
  }
  EXPECT_THAT(RunApp("A4 --set hardware=perfect" + Out()).text,
              AllOf(HasSubstr("hardware"), HasSubstr("there is no 'perfect'")));
}

// In a robot at rest a sensor shows its bias, and changes as often as it samples.
TEST_F(TenonQuadrupedTest, SensorsHaveBiasNoiseAndRateOfTheirOwn) {
  const Result result = RunApp(
      "stand --duration 0.2 --set 'sensors={encoders: {speed_bias_rad_per_s: 0.5}, "
      "torque: {rate_hz: 100, noise_ratio: 0.1}, foot_force: {rate_hz: 50, noise_ratio: 0.1, bias_N: 20}, "
      "imu: {rate_hz: 20, angular_velocity_bias_rad_per_s: [0.1, 0.2, 0.3], "
      "angular_velocity_noise_rad_per_s: 1e-4}}'" +
      Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
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
  const Result result =
      RunApp("stand --duration 4 --set 'forces=[{force_N: [0, 400, 0], duration_s: 2}]'" + Out());
  EXPECT_EQ(result.exit_code, 3) << result.text;
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"fell\": true"), HasSubstr("the robot fell: its trunk is")));
  EXPECT_THAT(Read(out / "report.html"), HasSubstr("the robot fell: its trunk is"));
}

// What no drive gives and what no ground lets in: the run comes to its end, and its verdict says what could
// not have been.
TEST_F(TenonQuadrupedTest, WhatNoRobotDoesIsNotFinished) {
  const auto judged = [&](const std::string& arguments, const char* reason) {
    const Result result = RunApp(arguments + Out());
    EXPECT_EQ(result.exit_code, 3) << arguments << ": " << result.text;
    EXPECT_THAT(Read(out / "summary.json"),
                AllOf(HasSubstr("\"finished\": false"), HasSubstr("\"fell\": false"), HasSubstr(reason)));
    EXPECT_NE(Read(out / "report.html").find(std::string("but ") + reason), std::string::npos);
  };
  judged("flat --duration 1.5 --set limit_speed=false", "a drive gave what it cannot: ");
  // A foot that is too soft for the weight, and joints that are.
  const std::string stand = "stand --set fall.min_height_ratio=0 --set fall.max_tilt_rad=3 ";
  judged(stand + "--duration 0.2 --set robot.contact.stiffness_N_per_m=2000",
         "a foot went into the ground: ");
  judged(stand +
             "--set pd.stiffness_N_m_per_rad=1 --set pd.damping_N_m_s_per_rad=0.5 "
             "--set pd.gravity_compensation=false --duration 0.35",
         "trunk, hip or knee went into the ground: ");
}

TEST_F(TenonQuadrupedTest, FiguresStandBesideTheirLimits) {
  const Result result = RunApp("stand --duration 0.2" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"torque_max_N_m", "torque_beyond_drive_max_N_m", "foot_depth_max_m",
                          "leg_clearance_min_m", "trunk_clearance_min_m", "ground_clearance_min_m"})
    EXPECT_THAT(summary.substr(summary.find("\"limits\"")), HasSubstr("\"" + std::string(key) + "\": {"))
        << key;
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("(at most 60)"), HasSubstr("(at most 0)"), HasSubstr("(at least -0.005)")));
  // A joint that others drive faster than its limit is no breach, so its speed has no limit here.
  EXPECT_THAT(summary.substr(summary.find("\"limits\"")), Not(HasSubstr("joint_speed_max_rad_per_s")));
}

// A robot that ice and a steady push carry backwards does not do what is asked of it, though it never falls.
TEST_F(TenonQuadrupedTest, ARobotThatLeavesItsPathIsNotFinished) {
  const std::string ice =
      "flat --duration 9 --set terrain.friction=0.03 --set walk.friction=0.03 "
      "--set 'forces=[{force_N: [-5, 0, 0], duration_s: 100}]'";
  const Result left = RunApp(ice + Out());
  EXPECT_EQ(left.exit_code, 3) << left.text;
  EXPECT_THAT(
      Read(out / "summary.json"),
      AllOf(HasSubstr("\"finished\": false"), HasSubstr("\"fell\": false"), HasSubstr("\"followed\": false"),
            HasSubstr("the path was not followed: the robot went ")));
  EXPECT_THAT(Read(out / "report.html"), HasSubstr("but the path was not followed"));
  const Result allowed = RunApp(ice + " --set walk.path_tolerance=0.9" + Out());
  EXPECT_EQ(allowed.exit_code, 0) << allowed.text;
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": true"));
  ASSERT_EQ(RunApp("stand --duration 0.1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": null"));
  ASSERT_EQ(RunApp("trot_in_place --duration 1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": null"));
}

TEST_F(TenonQuadrupedTest, SaysWhichDisturbancesNeverAct) {
  const Result result = RunApp(
      "flat --duration 0.2 --set 'forces=[{force_N: [20, 0, 0], duration_s: 0}, "
      "{force_N: [20, 0, 0], start_s: 5, duration_s: 1}, {duration_s: 1}, {force_N: [1, 0, 0], duration_s: "
      "1}]' "
      "--set 'random_forces=[{lower_N: 0, upper_N: 0}]' --set 'payload={position_m: [0, 0, 0.1]}' "
      "--set 'faults=[{at: imu, kind: drop_out, start_s: 3}]'" +
      Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json"), report = Read(out / "report.html");
  for (const char* note :
       {"forces.0 never acts: duration_s is 0", "forces.1 never acts: start_s = 5, and the run ends at 0.2 s",
        "forces.2 never acts: force_N and torque_N_m, times factor, are 0",
        "random_forces.0 never acts: upper_N is 0", "payload never acts: mass_kg is 0",
        "faults.0 never acts: start_s = 3, and the run ends at 0.2 s"}) {
    EXPECT_THAT(result.text, HasSubstr("warning: " + std::string(note) + "\n"));
    EXPECT_THAT(summary, HasSubstr(note));
    EXPECT_THAT(report, HasSubstr(note));
  }
  EXPECT_THAT(result.text, Not(HasSubstr("forces.3")));
  const Result quiet = RunApp("stand --duration 0.1" + Out());
  EXPECT_THAT(quiet.text, AllOf(Not(HasSubstr("warning")), Not(HasSubstr("note"))));
  EXPECT_THAT(Read(out / "summary.json"), Not(HasSubstr("notes")));
}

TEST_F(TenonQuadrupedTest, StandsOnASlopeUnderAPayloadAndASine) {
  const Result result = RunApp(
      "stand --duration 2 --set 'terrain={grade: [0.1, 0.1]}' --set payload.mass_kg=5 --set "
      "'forces=[{on: front_left, force_N: [20, 0, 0], duration_s: 2, frequency_rad_per_s: 1}]'" +
      Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "report.html"), HasSubstr("slope"));
}

TEST_F(TenonQuadrupedTest, WalksByTheStateEstimator) {
  const Result result = RunApp("flat --duration 1 --set walk.state=estimated" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"velocity_estimate_error_rms_m_per_s\": 0.00"),
                                                HasSubstr("\"tilt_estimate_error_max_rad\": 0.00")));
  ASSERT_EQ(RunApp("flat --duration 0.1" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), ::testing::Not(HasSubstr("velocity_estimate")));
}

// Nobody told the controller of the load that slides, or that its data of every body are off.
TEST_F(TenonQuadrupedTest, WalksWithASlidingLoadAndWrongData) {
  const Result result = RunApp(
      "flat --duration 1.5 --set 'payload={mass_kg: 5, position_m: [0, 0, 0.12], slides: {friction: 0.2}}' "
      "--set 'walk.model_error={mass_ratio: 0.2, com_ratio: 0.05, inertia_ratio: 0.3, length_ratio: 0.02}'" +
      Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "report.html"), HasSubstr("sliding load"));
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"com_error_max_m\": 0.0"));
  const auto knees = [&] { return Column(out, "loop.world.plant.state.q.front_left_knee [rad]"); };
  const std::vector<double> with_errors = knees();
  RunApp("flat --duration 1.5" + Out());
  EXPECT_NE(knees(), with_errors);
}

using TenonQuadrupedUsageTest = test::UsageTest;

TEST_P(TenonQuadrupedUsageTest, IsExitCode2WithAMessage) {
  ExpectExitCode2WithItsMessage(TENON_QUADRUPED);
}

INSTANTIATE_TEST_SUITE_P(
    All, TenonQuadrupedUsageTest,
    ::testing::Values(
        BadUsage{"", "no scenario given"}, BadUsage{"stnd", "did you mean 'stand'?"},
        BadUsage{"stand --set app=tenon-cdpr", "is a scenario of another app"},
        BadUsage{"stand --set robot=dogbt", "did you mean 'dogbot'?"},
        BadUsage{"stand --set robot.foot_radius_m=-1",
                 "--set robot.foot_radius_m=-1: robot.foot_radius_m: foot_radius_m is -1 m"},
        BadUsage{"stand --set 'forces=[{on: front_left, height: 3, duration_s: 1}]'",
                 "height = 3 must be from 0 to 1"},
        BadUsage{"flat --set walk.gaits.trot=1", "walk.gaits.trot: unknown key"},
        BadUsage{"stand --set duration_s=0", "duration_s = 0 must be positive"},
        BadUsage{"stand --set start_height_m=-0.1", "start_height_m = -0.1 must not be negative"},
        BadUsage{"stand --set fall.min_height_ratio=1", "the stance would be a fall"},
        BadUsage{"stand --set fall.max_height_m=0", "max_height_m = 0 must be positive"},
        BadUsage{"stand --set 'live.yaw_rad_per_s=[1,2]'",
                 "yaw_rad_per_s = [1, 2]: give the least, 0 or less"},
        BadUsage{"stand --set live.load_ratio=0", "load_ratio = 0 must be positive"},
        BadUsage{"stand --set fall.max_tilt_rad=4", "max_tilt_rad = 4 must be from"},
        BadUsage{"stand --set pd.stiffness_N_m_per_rad=0", "stiffness = 0 must be positive"},
        BadUsage{"stand --set pd.rate_hz=-1", "rate_hz: a rate of -1 Hz"},
        BadUsage{"stand --set sensors.torque.noise_ratio=-1", "noise_ratio = -1"},
        BadUsage{"stand --set sensors.imu.rate_hz=0", "rate_hz: a rate of 0 Hz"},
        BadUsage{"stand --set sensors.encoders.rate_hz=1e-30", "rate_hz: a rate of"},
        BadUsage{"stand --set integrator.rtol=1e308", "rtol = 1e+308"},
        BadUsage{"stand --set integrator.order=0", "order = 0 must be from 2 to 5"},
        BadUsage{"stand --set integrator.method=stabilized --set integrator.order=4",
                 "order = 4 must be from 2 to 3"},
        BadUsage{"stand --set sensors.imu.rate_hz=1e9", "rate_hz = 1000000000 must be at most 100000"},
        BadUsage{"stand --set integrator.atol_bristles=0", "atol_bristles = 0"},
        BadUsage{"stand --set payload.edges_m=[-1,-1,-1]", "edges_m = [-1, -1, -1] must not be negative"},
        BadUsage{"stand --set payload.position_m=[0,-1e308,0]",
                 "position_m = [0, -1e+308, 0] must be within 100 m"},
        BadUsage{"flat --set walk.friction=0", "friction = 0"},
        BadUsage{"flat --set walk.mass_error_ratio=-1", "the robot would have no mass"},
        BadUsage{"stand --set integrator.atol_position=1e308", "atol_position = 1e+308 must be from"},
        BadUsage{"stand --set 'report.plots=[{title: \"\\e[31m\", signals: [b]}]'",
                 "report: plot '\\x1b[31m'"},
        BadUsage{"stand --frobnicate$(printf '\\033')", "--frobnicate\\x1b"},
        BadUsage{"A3-sweep --set sweep.phases=100000", "10000 runs are the most"},
        BadUsage{"A3-sweep --compare", "--compare runs the scenario once with each observer"},
        BadUsage{"flat --set 'report.plots=[{title: a, signals: [b]}]'", "(with --set report.plots="},
        BadUsage{"flat --set 'profile.observer.legs.butterworth={order: 3, bandwidth_rad_per_s: 100}'",
                 "gains_per_s to []"},
        BadUsage{"A3-sweep --set sweep.phases=101 --set sweep.directions=100", "10000 runs are the most"},
        BadUsage{"stand --set 'forces=[{duration_s: 1, frequency_rad_per_s: -3}]'",
                 "frequency_rad_per_s = -3"},
        BadUsage{"estimated --set walk.state=guessed", "estimated"},
        BadUsage{"flat --set walk.zmp.horizon_steps=9", "horizon_steps is 9"},
        BadUsage{"stand --set payload.mass_kg=-1", "mass_kg = -1"},
        BadUsage{"stand --set 'payload={mass_kg: 1, slides: {reach_m: [-1, 0]}}'", "reach_m = [-1, 0]"},
        BadUsage{"stand --set 'payload={mass_kg: 1, slides: {friction: 11}}'", "friction = 11"},
        BadUsage{"A4 --set walk.model_error.mass_ratio=1", "mass_ratio = 1"},
        BadUsage{"stand --set 'forces=[{on: tail, duration_s: 1}]'", "tail"},
        BadUsage{"stand --set 'forces=[{on: rear_left, height: 2, duration_s: 1}]'",
                 "height = 2 must be from 0 to 1"},
        BadUsage{"stand --set 'random_forces=[{lower_N: 1, upper_N: 2, period_s: 0}]'",
                 "random_forces.0.period_s: period_s = 0 must be at least 1e-05"},
        BadUsage{"stand --set 'random_forces=[{lower_N: 3, upper_N: 2}]'", "upper_N = 2 must not be below"},
        BadUsage{"stand --set 'terrain={friction: -1}'", "friction"},
        // What is found after reading has a place, too.
        BadUsage{"stand --set robot=dogbt", "--set robot=dogbt: robot: there is no 'dogbt'"},
        BadUsage{"flat --set profile=standrd", "--set profile=standrd: profile: there is no 'standrd'"},
        BadUsage{"flat --set walk.gaits=none", "--set walk.gaits=none: walk.gaits: there is no 'none'"},
        BadUsage{"stand --set 'report.plots=[{title: a, signals: [b]}]'",
                 "stand.yaml:13:3: report: plot 'a'"},
        BadUsage{"flat --set profile.qp_rate_hz=-1", "profile.qp_rate_hz: a rate of -1 Hz is not positive"},
        BadUsage{"flat --set profile.sway_limit_rad_per_s2=-1",
                 "profile.sway_limit_rad_per_s2: sway_limit_rad_per_s2 = -1 must not be negative"},
        BadUsage{"flat --set terrain.grade=[50,0]", "terrain: the rear_left leg of 'dogbot' does not reach"},
        BadUsage{"stand --set robot.foot_radius_m=1e9",
                 "robot.foot_radius_m: foot_radius_m is 1e+09 m but must be at most 0.1"},
        BadUsage{"stand --set fall.max_height_m=0.01", "fall.max_height_m: 0.01 must be above 0.2"},
        BadUsage{"stand --set 'payload={mass_kg: 1, position_m: [0, 0, -1.5]}'",
                 "payload.position_m: the load reaches down to 1.5 m below the trunk"},
        BadUsage{"stand --set 'random_forces=[{lower_N: 1, upper_N: 2, period_s: 0.123456789123}]'",
                 "random_forces.0.period_s: a sample period of 0.123456789123 s"},
        BadUsage{"stand --set \"forces=[$(for i in 1 2 3 4 5 6 7 8; do printf '{duration_s: 1},'; done)"
                 "{duration_s: 1}]\"",
                 ": forces: 9 forces, those of random_forces among them, are too many: 7 are the most"},
        BadUsage{"stand --set report.plots.1.signals=[]", "report: the plot 'attitude"},
        BadUsage{"flat --duration 1 --set walk.path.segments.1.length_m=1e-4",
                 "flat.yaml:11:9: walk.path.segments.1: segments.1 is too short"}));

TEST(TenonQuadrupedListTest, ListsScenariosWithTheirDescriptions) {
  const Result result = RunApp("--list");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, AllOf(HasSubstr("holds its stance"), HasSubstr("lands from 0.1 m")));
}

}  // namespace
}  // namespace tenon::tenon_quadruped_test
