// Runs the binary as its users do.

#include <tenon/tests/apps/run_app.h>

#include <cmath>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace tenon::tenon_cdpr_test {
namespace {

namespace fs = std::filesystem;
using test::BadUsage;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_CDPR) + " " + arguments);
}

class TenonCdprTest : public test::AppTest {
 protected:
  // What a run of a user's robot left in `out` is moved to `home` and repeats that run from there, without
  // its files.
  void ExpectTheSameRunFrom(const fs::path& home) {
    const std::string first = Read(out / "signals.csv");
    fs::remove_all(home);
    fs::rename(out, home);
    const Result again = RunCommand("cd / && " TENON_CDPR " " + (home / "scenario.yaml").string() + Out());
    EXPECT_EQ(again.exit_code, 0) << again.text;
    EXPECT_EQ(Read(out / "signals.csv"), first);
    fs::remove_all(home);
  }
};

TEST_F(TenonCdprTest, WritesSummarySignalsScenarioAndGraph) {
  const Result result = RunApp("D1 --duration 0.5 --seed 7" + Out() + " --graph " + out.string() + ".dot");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"case", "seed", "controller", "finished", "fell", "end_reason", "simulated_s",
                          "wall_s", "real_time_factor", "tension_min_N", "tension_max_N", "command_min_N",
                          "command_max_N", "tension_rate_rms_N_per_s", "euler_oscillation_rms_rad",
                          "acceleration_rms_m_per_s2", "tracking_error_rms_m", "settling_time_s"}) {
    EXPECT_THAT(summary, HasSubstr("\"" + std::string(key) + "\": "));
  }
  EXPECT_THAT(summary, AllOf(HasSubstr("\"seed\": 7"), HasSubstr("\"finished\": true"),
                             HasSubstr("\"fell\": false"), HasSubstr("\"simulated_s\": 0.5")));
  const std::string signals = Read(out / "signals.csv");
  EXPECT_THAT(signals, AllOf(HasSubstr("time [s],"), HasSubstr("loop.plant.cables.tension.0 [N]"),
                             HasSubstr("\n0.5,")));
  EXPECT_THAT(Read(out / "scenario.yaml"), AllOf(HasSubstr("case: D1"), HasSubstr("pose_rate_hz: 200")));
  const std::string graph = Read(out.string() + ".dot");
  EXPECT_THAT(graph, AllOf(HasSubstr("cluster_loop"), HasSubstr("mpc")));
  EXPECT_LT(fs::file_size(out / "report.html"), 2e6);
  EXPECT_THAT(Read(out / "report.html").substr(0, 500), HasSubstr("<title>D1: circle of 0.5 m radius"));
  fs::remove(out.string() + ".dot");
}

TEST_F(TenonCdprTest, ControllersByName) {
  for (const char* controller : {"mpc_equilibrium", "mpc_zero", "pd"}) {
    const Result result = RunApp("D1 --duration 0.3 --controller " + std::string(controller) + Out());
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"controller\": \"" + std::string(controller) + "\""));
  }
}

TEST_F(TenonCdprTest, ComparesTheControllers) {
  const Result result = RunApp("D1 --compare --duration 0.3" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* controller : {"mpc_equilibrium", "mpc_zero", "pd"}) {
    EXPECT_THAT(summary, HasSubstr("\"" + std::string(controller) + "\": {"));
    EXPECT_THAT(Read(out / controller / "signals.csv"), HasSubstr("loop.command.0 [N]"));
    EXPECT_THAT(Read(out / controller / "scenario.yaml"), HasSubstr(controller));
  }
  for (const char* key : {"mpc_time_median_us", "mpc_time_p99_us", "\"mpc_fallbacks\": 0.0"})
    EXPECT_THAT(summary, HasSubstr(key));
}

TEST_F(TenonCdprTest, WrittenScenarioRepeatsTheRun) {
  ASSERT_EQ(RunApp("D1 --duration 0.3 --set path.radius_m=0.4" + Out()).exit_code, 0);
  const std::string first = Read(out / "signals.csv");
  const Result again = RunApp((out / "scenario.yaml").string() + Out() + "/again");
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_EQ(Read(out / "again" / "signals.csv"), first);
}

// A robot of the user's, changed on the command line: what the run leaves repeats it elsewhere, without the
// file.
TEST_F(TenonCdprTest, WrittenScenarioStartsFromAnywhere) {
  const fs::path home = out.string() + "_home";
  fs::create_directories(home);
  fs::copy_file(std::string(TENON_ROBOTS_DIR) + "/cdpr_4.yaml", home / "mine.yaml");
  std::ofstream(home / "own.yaml") << "extends: D1\nrobot: mine.yaml\nduration_s: 0.2\n";
  const Result result = RunApp((home / "own.yaml").string() + " --set robot.mass_kg=16" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "scenario.yaml"),
              AllOf(HasSubstr("files/robot.yaml"), HasSubstr("mass_kg: 16"), HasSubstr("format: 1")));
  EXPECT_THAT(Read(out / "report.html"), HasSubstr("mine.yaml, changed with"));
  ExpectTheSameRunFrom(home);
}

TEST_F(TenonCdprTest, AFileThatIsMissingIsToldWithFileLineAndKey) {
  fs::create_directories(out);
  std::ofstream(out / "own.yaml") << "extends: D1\nrobot: robots/gone.yaml\n";
  const Result result = RunApp((out / "own.yaml").string());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.text, AllOf(HasSubstr(out.string() + "/own.yaml:2:8: robot: cannot read '" +
                                           out.string().substr(0, 40)),
                                 HasSubstr("no such file; check the path")));
}

TEST_F(TenonCdprTest, AReportWithoutItsScriptsIsExitCode5) {
  const Result result = RunCommand("TENON_JAVASCRIPT_DIR=/nowhere " TENON_CDPR " D1 --duration 0.1" + Out());
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstr("apt-get install libjs-"));
}

// Two rings of six anchors, in a file of the user's.
TEST_F(TenonCdprTest, FliesARobotOfTwelveCables) {
  const fs::path robot = test::TemporaryPath("twelve.yaml");
  {
    std::ofstream file(robot);
    file << "name: twelve\nmass_kg: 15\ninertia_kg_m2: [0.5, 0.5, 0.9]\ncables:\n";
    for (int i = 0; i < 12; ++i) {
      const int side = i % 2 == 0 ? 1 : -1;
      const double anchor = i * std::numbers::pi / 6, attachment = anchor + side * std::numbers::pi / 6;
      file << "  - {anchor_m: [" << 4 * std::cos(anchor) << ", " << 4 * std::sin(anchor) << ", "
           << 3.75 + 0.25 * side << "], attachment_m: [" << 0.35 * std::cos(attachment) << ", "
           << 0.35 * std::sin(attachment) << ", 0.1]}\n";
    }
    file << "cable_properties: {axial_stiffness_N: 27000, axial_damping_N_s: 135, tension_min_N: 5, "
            "tension_max_N: 800}\n"
            "winch: {mode: tension, time_constant_s: 0.02, reel_damping_N_s_per_m: 90}\n";
  }
  for (const char* controller : {"mpc_equilibrium", "pd"}) {
    const Result result =
        RunApp("circle_6 --duration 1 --set robot=" + robot.string() + " --controller " + controller + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"finished\": true"));
    for (const double tension : test::Column(out, "loop.plant.cables.tension.11 [N]")) ASSERT_GT(tension, 0);
    EXPECT_THAT(Read(out / "report.html"), HasSubstr("cable 11"));
  }
  fs::remove(robot);
}

// What is special about cables and winches changes the flight, and costs none.
TEST_F(TenonCdprTest, FliesWithCablesAsTheyAre) {
  ASSERT_EQ(RunApp("D1 --duration 0.5" + Out()).exit_code, 0);
  const std::vector<double> ideal = test::Column(out, "loop.plant.cables.tension.0 [N]");
  for (const char* run :
       {"D1-sag", "circle_8-pulleys",
        "D1 --set 'robot={file: cdpr_4, winch: {drum: {radius_m: 0.036, cable_diameter_m: 0.005, "
        "turns_per_layer: 10, cable_length_m: 10.8}, "
        "differential: {pairs: [[0, 1], [2, 3]], motor_tension_max_N: 75}}}'"}) {
    const Result result = RunApp(std::string(run) + " --duration 0.5" + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_NE(test::Column(out, "loop.plant.cables.tension.0 [N]"), ideal);
  }
  const auto refuses = [&](const std::string& winch, const char* place, const char* what, bool known = true) {
    const Result result = RunApp("D1 --set 'robot={file: cdpr_4, winch: {" + winch +
                                 "}}' --set known_pulleys=" + (known ? "true" : "false") + Out());
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.text, AllOf(HasSubstr(place), HasSubstr(what)));
  };
  refuses("pulley_radius_m: -0.04", "winch.pulley_radius_m",
          "pulley_radius is -0.04 m but must not be negative");
  refuses("pulley_radius_m: 4", "path: The path leaves the workspace at t = 0 s",
          "Cable 0 of 'cdpr_4' would end");
  refuses("pulley_radius_m: 4", "robot: block 'loop': block 'plant'", "at the start cable 0 ends", false);
  refuses("pulley_radius: 0.04", "robot", "pulley_radius_m");
  refuses("drum: {radius_m: 0.036}", "robot", "cable_diameter_m");
}

// What lies between changes what the controllers command, and costs no flight.
TEST_F(TenonCdprTest, FliesWithTheHardwareOfARobot) {
  for (const char* controller : {"mpc_equilibrium", "mpc_zero", "pd", "pd_feedforward", "pd_offset_free"}) {
    const std::string run = std::string("D1 --duration 0.5 --controller ") + controller;
    EXPECT_EQ(RunApp(run + Out()).exit_code, 0);
    const std::vector<double> as_told = test::Column(out, "loop.command.0 [N]");
    const Result result = RunApp(run + " --set hardware=standard" + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_NE(test::Column(out, "loop.command.0 [N]"), as_told);
    EXPECT_THAT(Read(out / "scenario.yaml"), HasSubstr("hardware: standard"));
  }
  const auto refuses = [&](const std::string& set, const char* place, const char* what) {
    const Result result = RunApp("D1 --set '" + set + "'" + Out());
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.text, AllOf(HasSubstr(place), HasSubstr(what)));
  };
  refuses("path.tension_aim_N=50", "path", "tension_aim_N = 50");
  refuses("load.bandwidth_rad_per_s=300", "load", "below the rate");
  refuses("hardware=perfect", "hardware", "there is no 'perfect'");
  refuses("hardware={file: standard, link: {delay_s: 0.001, jitter_s: 0.002}}", "hardware",
          "jitter_s = 0.002");
  refuses("hardware={file: standard, winches: {gain_deviation: 2}}", "hardware", "gain_deviation");
  refuses("hardware={file: standard, winches: {friction_speed_m_per_s: 0}}", "hardware",
          "friction_speed_m_per_s");
  refuses("hardware={file: standard, sensors: {cables: {latency_samples: -1}}}", "hardware",
          "latency_samples");
  refuses("hardware={file: standard, sensors: {pose: {offset_m: -1}}}", "hardware", "offset_m");
  refuses("hardware={file: standard, sensors: {imu: {misalignment_rad: -1}}}", "hardware",
          "misalignment_rad");
}

TEST_F(TenonCdprTest, BrokenLimitIsExitCode3) {
  const Result result =
      RunApp("D1 --controller pd --duration 5 --set pd.stiffness_N_per_m=60000 --set pd.damping_N_s_per_m=1" +
             Out());
  EXPECT_EQ(result.exit_code, 3) << result.text;
  EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"finished\": false"), HasSubstr("is slack")));
}

TEST_F(TenonCdprTest, NumericalFailureIsExitCode4AndKeepsWhatWasWritten) {
  const Result result = RunApp(
      "D1 --controller pd --duration 5 --set pd.stiffness_N_per_m=1e300 --set forbid_slack=false --set "
      "integrator.rtol=1e-14 --set integrator.atol=1e-300 --set max_tension_ratio=2" +
      Out());
  EXPECT_EQ(result.exit_code, 4) << result.text;
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"finished\": false"), HasSubstr("the integrator fails")));
  EXPECT_THAT(Read(out / "signals.csv"), HasSubstr("\n0,"));
}

using TenonCdprUsageTest = test::UsageTest;

TEST_P(TenonCdprUsageTest, IsExitCode2WithAMessage) {
  ExpectExitCode2WithItsMessage(TENON_CDPR);
}

INSTANTIATE_TEST_SUITE_P(
    All, TenonCdprUsageTest,
    ::testing::Values(
        BadUsage{"", "no scenario given"}, BadUsage{"D11", "did you mean 'D1'?"},
        BadUsage{"missing.yaml", "no such file"}, BadUsage{"D1 --frobnicate", "--frobnicate"},
        BadUsage{"D1 --duration -1", "--duration: -1 must be a positive number"},
        BadUsage{"D1 --set pd", "write key=value"},
        BadUsage{"D1 --set pd.stifness_N_per_m=1", "stiffness_N_per_m"},
        BadUsage{"D1 --controller mpc", "--set controller=mpc"},
        BadUsage{"D1 --controller pd --compare", "--controller excludes --compare"},
        BadUsage{"D1 --set mpc=null", "there is no section mpc"},
        BadUsage{"D1 --set mpc.mass_error=-1", "the model would have no mass"},
        BadUsage{"D1 --set mpc.horizon_s=0.015", "horizon = 0.015 s"},
        BadUsage{"D1 --set robot=cdpr_5", "did you mean 'cdpr_"}, BadUsage{"D9", "did you mean 'D"},
        BadUsage{"D1 --set robot.mass=6", "--set robot.mass=6: robot.mass: unknown key; the unit is missing"},
        BadUsage{"D1 --set mpc.rate_hz=0", "--set mpc.rate_hz=0: mpc.rate_hz: a rate of 0 Hz"},
        BadUsage{"D1 --set 'path={kind: spline, points_m: [[0,0,2],[0,0,1]], times_s: [1, 1]}'",
                 ": path.times_s.1: times_s.1 = 1: the times must be finite and increase"},
        BadUsage{"D1 --seed -1", "--seed: -1 must be an integer from 0 to 18446744073709551615"},
        BadUsage{"D1 --set duration_s=-3", "duration_s = -3 must be positive"},
        BadUsage{"D1 --set app=tenon-walk", "not a scenario of"},
        BadUsage{"D1 --set payload.mass_kg=-1", "mass_kg = -1"},
        BadUsage{"D1 --set pd.rate_hz=0", "rate_hz: a rate of 0 Hz"},
        BadUsage{"D1 --set noise.imu_rate_hz=-5", "imu_rate_hz: a rate of -5 Hz"},
        BadUsage{"D1 --set mpc.num_steps=1000000", "num_steps = 1000000 must be from 1 to 1000"},
        BadUsage{"D1 --set mpc.max_fallbacks_in_a_row=-1", "max_fallbacks_in_a_row = -1"},
        BadUsage{"D1 --set integrator.rtol=1e308", "rtol = 1e+308"},
        BadUsage{"D1 --set log_rate_hz=0", "log_rate_hz: a rate of 0 Hz"},
        BadUsage{"D1 --set max_tension_ratio=0.5", "max_tension_ratio = 0.5 must be from 1 to 2"},
        BadUsage{"D1 --set seed=010", "begins with a 0"},
        BadUsage{"D1 --set seed=18446744073709551616", "expected an integer from 0"},
        BadUsage{"D1 --set 'payload={attach_s: 2, release_s: 1}'", "release_s = 1 lies before attach_s = 2"},
        BadUsage{"D1 --set path.kind=hold", "a path that holds needs one entry in points_m, found 0"},
        BadUsage{"D1 --set path.kind=line", "a line needs two entries in points_m, found 0"},
        BadUsage{"D1 --set path.kind=spline --set 'path.points_m=[[0,0,2],[0,0,1]]'",
                 "give one time per point"},
        BadUsage{"D1 --set path.attitudes_rad=[[0,0,0]]", "attitudes_rad are for a line or a spline"},
        BadUsage{"turn_8 --set path.attitude_rad=[0,0,0]", "path: attitude_rad and attitudes_rad"},
        BadUsage{"turn_8 --set path.attitudes_rad=[[0,0,0]]", "give one attitude per point"},
        BadUsage{"D1 --set path.kind=waypoints", "path: waypoints has 0 entries"},
        BadUsage{"waypoints --set path.waypoints.0.travel_s=1", "waypoints.0 is the start"},
        BadUsage{"waypoints --set path.waypoints.1.travel_s=1",
                 "waypoints.1: give one of travel_s and speed_m"},
        BadUsage{"waypoints --set path.waypoints.1.speed_m_per_s=null", "not none"},
        BadUsage{"waypoints --set path.waypoints.1.speed_m_per_s=0",
                 "waypoints.1.speed_m_per_s: speed_m_per_s = 0"},
        BadUsage{"waypoints --set path.waypoints.1.dwell_s=-1", "waypoints.1.dwell_s: dwell_s = -1"},
        BadUsage{"waypoints --set path.waypoints.1.position_m=[0,0,1.6]", "waypoints.1"},
        BadUsage{"waypoints --set path.waypoints.0.attitude_rad=null", "give that of waypoints.0 as well"},
        BadUsage{"waypoints --set path.attitude_rad=[0,0,0]", "attitude_rad"},
        BadUsage{"D1 --set path.kind=file", "path: a path of kind file needs a file"},
        BadUsage{"scan --set path.tension_aim_N=100", "tension_aim_N = 100"},
        BadUsage{"D1 --set cable_diameter_m=-1", "cable_diameter_m = -1"},
        BadUsage{"gust --set gusts.0.duration_s=0", "duration_s"},
        BadUsage{"pendulum --set hanging_load.mass_kg=0", "mass_kg"},
        BadUsage{"pendulum --set hanging_load.swing_m=[1,1]", "the rope only length_m = 1"},
        BadUsage{"D1 --set mpc.bounds=soft", "newton"},
        BadUsage{"D1 --set path.center_m=[0,0,5]", "it is not below the highest anchor"},
        BadUsage{
            "D1 --set 'report.plots=[{title: speed, signals: [loop.plant.platform.v_B]}]'",
            "plot 'speed': there is no signal 'loop.plant.platform.v_B'; did you mean 'loop.plant.platform"},
        BadUsage{"D1 --set 'report.plots=[{title: speed}]'", "signals"},
        BadUsage{"D1 --set 'payload={mass_kg: 1, position_m: [1e6, 0, 0]}'",
                 "position_m = [1000000, 0, 0] must be within 100 m"},
        BadUsage{"D1 --set integrator.atol=1e308", "atol = 1e+308 must be from 1e-300 to 0.1"},
        BadUsage{"D1 --set mpc.mass_error=1e300", "mpc.mass_error: mass_error = 1e+300 must be above -1"},
        BadUsage{"D1 --set mpc.mass_error=99", "--set mpc.mass_error=99: mpc.mass_error: The path leaves"},
        BadUsage{"D1 --set robot.mass_kg=1e300", "robot.mass_kg: mass is 1e+300 kg: no platform"},
        BadUsage{"D1 --set mpc.weights.position_per_m2=-1",
                 "mpc.weights.position_per_m2: weights.position = -1 must be finite"},
        BadUsage{"D1 --set mpc.weights.tension_per_N2=0",
                 "mpc.weights.tension_per_N2: weights.tension = 0 must be positive"},
        BadUsage{"D1 --set mpc.num_steps=1000", "mpc.num_steps: num_steps = 1000"},
        BadUsage{"D1 --set 'path={kind: line, points_m: [[0,0,2],[0,0,2.1]], times_s: [0, 1e6]}'",
                 "path.times_s: the path takes 1000000 s"},
        BadUsage{"D1 --set \"report.events=[$(seq -s, 1001)]\"", "report.events: events has 1001 entries"},
        BadUsage{"D1 --set start_offset_m=[0,0,1e30]", "start_offset_m = [0, 0, 1e+30] must be within 100 m"},
        BadUsage{"D1 --set path.radius_m=-1", "path.radius_m: radius_m = -1 must be positive"},
        BadUsage{"D1 --set path.center_m=[1e9,0,2]",
                 "path.center_m: center_m = [1000000000, 0, 2] must be within"},
        BadUsage{"waypoints --set path.waypoints.1.position_m=[1e300,0,2]",
                 "path.waypoints.1.position_m: position_m = [1e+300, 0, 2] must be within"},
        BadUsage{"D1 --set robot.cables=[1,2,3]", "robot.cables.0: expected a map"},
        BadUsage{"D1 --graph /tmp/x.bmp", "ends in .svg or .dot"}));

TEST(TenonCdprOutputTest, DirectoryThatCannotBeMade) {
  const Result result = RunApp("D1 --out /proc/nowhere");
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstr("output directory '/proc/nowhere'"));
}

TEST_F(TenonCdprTest, WhatNoRobotDoesEndsTheRun) {
  const auto ends = [&](const char* arguments, const char* reason) {
    const Result result =
        RunApp("D1 --controller pd --duration 2 --set forbid_slack=false " + std::string(arguments) + Out());
    EXPECT_EQ(result.exit_code, 3) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr(reason));
  };
  ends("--set start_offset_m=[0,0,-2.5]", "the platform reaches");
  ends("--set start_offset_m=[0,0,90]", "m away from the middle of the anchors");
  ends("--set pd.stiffness_N_per_m=1e5 --set pd.damping_N_s_per_m=0 --set start_offset_m=[1,0,0]",
       "more than the 880 N that its winch holds");
}

// Nor do cables touch, or loads go through the floor: the run comes to its end, and its verdict says what
// could not have been.
TEST_F(TenonCdprTest, WhatNoCableDoesIsNotFinished) {
  const auto judged = [&](const std::string& arguments, const char* reason) {
    const Result result = RunApp(arguments + Out());
    EXPECT_EQ(result.exit_code, 3) << arguments << ": " << result.text;
    EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"finished\": false"), HasSubstr(reason)));
    EXPECT_NE(Read(out / "report.html").find(std::string("but ") + reason), std::string::npos);
  };
  judged("waypoints --duration 5.5 --set cable_diameter_m=0.3", "two cables touched: the axes of ");
  judged("D1 --controller pd --duration 1 --set forbid_slack=false --set start_turn_rad=[0,0,2.2]",
         "the platform turned beyond the reach of its cables: by 2.2 rad");
  judged("pendulum --duration 0.3 --set path.center_m=[0,0,0.9] --set 'path.points_m=[[0,0,0.9]]'",
         "platform, load or cables went through the floor: by ");
}

TEST_F(TenonCdprTest, FiguresStandBesideTheirLimits) {
  const Result result = RunApp("D1 --duration 0.2" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"tension_max_N", "cable_distance_min_m", "cable_platform_angle_min_rad",
                          "floor_clearance_min_m", "turn_max_rad"})
    EXPECT_THAT(summary.substr(summary.find("\"limits\"")), HasSubstr("\"" + std::string(key) + "\": {"))
        << key;
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("(at most 800)"), HasSubstr("(at most 880)"), HasSubstr("(at least 0.005)")));
}

// A figure beyond its limit is not printed like the limit: 4.9999 mm are less than 5 mm.
TEST_F(TenonCdprTest, AFigureAndItsLimitAreToldApart) {
  const std::string flight = "waypoints --duration 5.5 --set log_rate_hz=10 ",
                    key = "\"cable_distance_min_m\": ";
  ASSERT_EQ(RunApp(flight + Out()).exit_code, 0);
  const std::string summary = Read(out / "summary.json");
  const double least = std::stod(summary.substr(summary.find(key) + key.size()));
  std::ostringstream diameter;
  diameter << std::setprecision(12) << least + 1e-7;
  const Result result = RunApp(flight + "--set cable_diameter_m=" + diameter.str() + Out());
  EXPECT_EQ(result.exit_code, 3) << result.text;
  const auto expect_less = [&](const char* from, const char* format) {
    double value = 0, limit = 0;
    const std::size_t at = result.text.find(from);
    ASSERT_NE(at, std::string::npos) << result.text;
    ASSERT_EQ(std::sscanf(result.text.c_str() + at, format, &value, &limit), 2) << result.text.substr(at, 80);
    EXPECT_LT(value, limit);
  };
  expect_less(" were ", " were %lf mm apart, less than %lf mm");
  expect_less("cable_distance_min_m", "cable_distance_min_m %lf m (at least %lf)");
}

TEST_F(TenonCdprTest, APlatformThatLeavesItsPathIsNotFinished) {
  const std::string push =
      "D1 --controller pd --duration 2 --set forbid_slack=false --set 'gusts=[{force_N: "
      "[0, 60, 0], start_s: 0.5, duration_s: 1}]'";
  ASSERT_EQ(RunApp(push + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": true"));
  const Result left = RunApp(push + " --set path_tolerance=0.001" + Out());
  EXPECT_EQ(left.exit_code, 3) << left.text;
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"finished\": false"), HasSubstr("\"followed\": false"),
                    HasSubstr("the path was not followed: the robot left it by ")));
  ASSERT_EQ(RunApp("D2 --duration 0.2" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": null"));
}

TEST_F(TenonCdprTest, SaysWhichDisturbancesNeverAct) {
  const auto says = [&](const std::string& arguments, const std::string& note) {
    const Result result = RunApp("D2 --duration 0.2 " + arguments + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(result.text, HasSubstr("warning: " + note));
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr(note));
    EXPECT_THAT(Read(out / "report.html"), HasSubstr(note));
  };
  says("", "payload never acts: attach_s = 1, and the run ends at 0.2 s");
  says("--set payload.release_s=1", "payload never acts: release_s and attach_s are both 1");
  says("--set payload.mass_kg=0", "payload never acts: mass_kg is 0");
  says("--set 'gusts=[{force_N: [0, 0, 0], start_s: 0, duration_s: 1}]'", "gusts.0 never acts: force_N is 0");
}

// From waypoint to waypoint: at rest where it dwells, with speeds as asked in between, the attitude likewise.
TEST_F(TenonCdprTest, FliesAlongWaypoints) {
  const Result result = RunApp("waypoints --duration 12 --set log_rate_hz=100" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string reference = "loop.reference.reference.";
  const auto z = test::Column(out, reference + "position.z [m]"),
             y = test::Column(out, reference + "position.y [m]");
  const auto yaw = test::Column(out, reference + "euler.z [rad]");
  const auto speed = test::Column(out, reference + "velocity.z [m/s]");
  EXPECT_NEAR(z[100], 1.6, 1e-9);  // at 1 s
  EXPECT_NEAR(yaw[100], 0, 1e-6);
  const std::size_t passed = 100 + 400;  // 1 m at 0.25 m/s later
  EXPECT_NEAR(y[passed], 0.8, 1e-3);
  EXPECT_NEAR(yaw[passed], 0.3, 1e-3);
  EXPECT_LT(speed[passed], -0.01) << "it does not stop there";
  for (std::size_t i = passed + 300; i <= passed + 500; i += 50) {
    EXPECT_NEAR(z[i], 0.9, 1e-9) << i;
    EXPECT_NEAR(speed[i], 0, 1e-9) << i;
  }
  for (std::size_t i = 2; i < z.size(); ++i)
    EXPECT_LT(std::abs(z[i] - 2 * z[i - 1] + z[i - 2]), 1.5e-4) << i;  // no more than 1.5 m/s^2
}

// The table is copied beside the scenario that the run leaves, which starts from there.
TEST_F(TenonCdprTest, FliesAlongAPathFromAFile) {
  const fs::path home = out.string() + "_home";
  fs::create_directories(home);
  std::ofstream(home / "own.yaml") << "extends: scan\npath: {file: way.csv}\nduration_s: 0.3\n";
  std::ofstream(home / "way.csv") << "t, x, y, z\r\n0,0,0,2\r\n0.3,0.01,0,2\r\n1,0.1,0.1,1.9\r\n";
  ASSERT_EQ(RunApp((home / "own.yaml").string() + Out()).exit_code, 0);
  EXPECT_NEAR(test::Column(out, "loop.reference.reference.position.x [m]").back(), 0.01, 1e-12);
  ExpectTheSameRunFrom(home);
}

TEST_F(TenonCdprTest, AWrongPathFileIsToldWithItsLine) {
  fs::create_directories(out);
  std::ofstream(out / "own.yaml") << "extends: scan\npath: {file: way.csv}\nduration_s: 0.1\n";
  const auto refused = [&](const std::string& text, const char* message) {
    std::ofstream(out / "way.csv") << text;
    const Result result = RunApp((out / "own.yaml").string() + " --out " + out.string() + "/run");
    EXPECT_EQ(result.exit_code, 2) << text;
    EXPECT_THAT(result.text, HasSubstr(message)) << text;
  };
  refused("", "way.csv:1: the columns are '': give 't,x,y,z' or");
  refused("t,x,y\n", "way.csv:1: the columns are 't,x,y'");
  refused("t,x,y,z\n0,0,0,2\n", "way.csv:2: 1 points");
  refused("t,x,y,z\n0,0,0,2\n1,0,2\n", "way.csv:3: 3 values, but the header names 4 columns");
  refused("t,x,y,z\n0,0,0,2\n1,0,nan,2\n", "way.csv:3: 'nan'");
  refused("t,x,y,z\n0,0,0,2\n1,2 3,0,2\n", "way.csv:3: '2 3'");
  refused("t,x,y,z\n0,0,0,2\n1,0,,2\n", "way.csv:3: ''");
  refused("t,x,y,z\n0,0,0,2\n\n0,0,1,2\n",
          "way.csv:4: t = 0 s does not come after the 0 s of the row before");
  refused("t,x,y,z\n0,0,0,2\n1,0,0,9\n", "path: The path leaves the workspace at t = ");
  fs::remove(out / "way.csv");
  const Result gone = RunApp((out / "own.yaml").string());
  EXPECT_EQ(gone.exit_code, 2);
  EXPECT_THAT(gone.text, AllOf(HasSubstr("own.yaml:2"), HasSubstr("way.csv")));
}

TEST(TenonCdprListTest, ListsScenariosWithTheirDescriptions) {
  const Result result = RunApp("--list");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, HasSubstr("circle of 0.5 m radius in 10 s, four cables"));
}

TEST(TenonCdprListTest, KeysAndVersion) {
  const Result keys = RunApp("--keys");
  EXPECT_EQ(keys.exit_code, 0);
  EXPECT_THAT(keys.text,
              AllOf(HasSubstr("path.ramp_s"), HasSubstr("time in which the circle's speed is reached"),
                    HasSubstr("faults[].at"), HasSubstr("robot.cable_properties.")));
  EXPECT_EQ(RunApp("D1 --keys").exit_code, 0);
  EXPECT_THAT(RunApp("D1 --keys --set robot=mine.yaml").text,
              AllOf(HasSubstr("--set robot=mine.yaml: robot: cannot read '"), HasSubstr("no such file")));
  EXPECT_EQ(RunApp("--version").text, "tenon-cdpr " TENON_VERSION "\n");
}

TEST(TenonCdprListTest, BashCompletesScenariosOptionsAndKeys) {
  const auto completed = [](const std::string& words, int at) {
    return RunCommand("bash -c 'source " TENON_COMPLETION "; COMP_WORDS=(" TENON_CDPR " " + words +
                      "); COMP_CWORD=" + std::to_string(at) + "; _tenon; echo ${COMPREPLY[@]}'")
        .text;
  };
  EXPECT_THAT(completed("circle_", 1), HasSubstr("circle_6 circle_8"));
  EXPECT_EQ(completed("--dur", 1), "--duration\n");
  EXPECT_EQ(completed("D1 --set path.ra", 3), "path.radius_m= path.ramp_s=\n");
  EXPECT_THAT(completed("D1 --set faults", 3), HasSubstr("faults.0.at="));
}

// What it hands to zsh, which then takes what begins as the word does.
TEST(TenonCdprListTest, ZshCompletesScenariosOptionsAndKeys) {
  if (RunCommand("zsh --version").exit_code != 0) GTEST_SKIP() << "zsh is not installed";
  const auto offered = [](const std::string& words) {
    return RunCommand(
               "zsh -f -c 'compadd() { print -r -- \"$@\" }; _files() { print -r -- files \"$@\" }; "
               "complete() { words=(\"$@\"); CURRENT=$#words; PREFIX=$words[CURRENT]; "
               "source " TENON_ZSH_COMPLETION " }; complete " TENON_CDPR " " +
               words + "'")
        .text;
  };
  EXPECT_THAT(offered("circle_"), AllOf(HasSubstr(" circle_6 circle_8 "), HasSubstr("files -g *.yaml")));
  EXPECT_THAT(offered("--dur"), AllOf(HasSubstr("--duration"), Not(HasSubstr("circle_6"))));
  EXPECT_THAT(offered("D1 --set path.ra"),
              AllOf(HasSubstr("-S = -- "), HasSubstr(" path.radius_m "), HasSubstr(" faults.0.at ")));
  EXPECT_EQ(offered("D1 --out x"), "files\n");
}

TEST(TenonCdprListTest, HelpSaysWhatThereIs) {
  const Result result = RunApp("--help");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, AllOf(HasSubstr("--controller"), HasSubstr("--set"), HasSubstr("Exit codes")));
}

}  // namespace
}  // namespace tenon::tenon_cdpr_test
