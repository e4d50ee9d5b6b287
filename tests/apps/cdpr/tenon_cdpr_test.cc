// Runs the binary as its users do.

#include <cmath>
#include <fstream>
#include <numbers>

#include <tenon/tests/apps/run_app.h>

namespace tenon {
namespace {

namespace fs = std::filesystem;
using test::BadUsage;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_CDPR) + " " + arguments);
}

using TenonCdprTest = test::AppTest;

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

TEST_F(TenonCdprTest, FliesRobotsWithSixAndEightCables) {
  for (const char* scenario : {"circle_6", "circle_8"}) {
    const Result result = RunApp(std::string(scenario) + " --duration 3" + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"finished\": true"));
  }
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
  refuses("path.tension_aim_N=50", "path", "tension_aim_N = 50 takes attitude_rad");
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
      "integrator.rtol=1e-14 --set integrator.atol=1e-300 --set max_tension_ratio=1e300" +
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
        BadUsage{"D1 --duration -1", "--duration"}, BadUsage{"D1 --set pd", "give it as key=value"},
        BadUsage{"D1 --set pd.stifness_N_per_m=1", "stiffness_N_per_m"},
        BadUsage{"D1 --controller mpc", "--set controller=mpc"},
        BadUsage{"D1 --controller pd --compare", "--controller excludes --compare"},
        BadUsage{"D1 --set mpc=null", "there is no section mpc"},
        BadUsage{"D1 --set mpc.mass_error=-1", "the model would have no mass"},
        BadUsage{"D1 --set mpc.horizon_s=0.015", "no multiple of the period"},
        BadUsage{"D1 --set robot=cdpr_5", "did you mean 'cdpr_"},
        BadUsage{"D1 --set duration_s=-3", "duration_s = -3 must be positive"},
        BadUsage{"D1 --set app=tenon-walk", "a scenario of another app"},
        BadUsage{"D1 --set payload.mass_kg=-1", "mass_kg = -1"},
        BadUsage{"D1 --set pd.rate_hz=0", "rate_hz: a rate of 0 Hz"},
        BadUsage{"D1 --set noise.imu_rate_hz=-5", "imu_rate_hz: a rate of -5 Hz"},
        BadUsage{"D1 --set mpc.num_steps=1000000", "num_steps = 1000000 must be from 1 to 1000"},
        BadUsage{"D1 --set mpc.max_fallbacks_in_a_row=-1", "max_fallbacks_in_a_row = -1"},
        BadUsage{"D1 --set integrator.rtol=1e308", "rtol = 1e+308"},
        BadUsage{"D1 --set log_rate_hz=0", "log_rate_hz: a rate of 0 Hz"},
        BadUsage{"D1 --set max_tension_ratio=0.5", "max_tension_ratio = 0.5"},
        BadUsage{"D1 --set seed=010", "begins with a 0"},
        BadUsage{"D1 --set seed=18446744073709551616", "expected an integer from 0"},
        BadUsage{"D1 --set 'payload={attach_s: 2, release_s: 1}'", "release_s = 1 lies before attach_s = 2"},
        BadUsage{"D1 --set path.kind=hold", "a path that holds needs one entry in points_m, found 0"},
        BadUsage{"D1 --set path.kind=line", "a line needs two entries in points_m, found 0"},
        BadUsage{"D1 --set path.kind=spline --set 'path.points_m=[[0,0,2],[0,0,1]]'",
                 "give one time per point"},
        BadUsage{"D1 --set path.center_m=[0,0,5]", "it is not below the highest anchor"},
        BadUsage{
            "D1 --set 'report.plots=[{title: speed, signals: [loop.plant.platform.v_B]}]'",
            "plot 'speed': there is no signal 'loop.plant.platform.v_B'; did you mean 'loop.plant.platform"},
        BadUsage{"D1 --set 'report.plots=[{title: speed}]'", "signals"},
        BadUsage{"D1 --graph /tmp/x.bmp", "ends in .svg or .dot"}));

TEST(TenonCdprOutputTest, DirectoryThatCannotBeMade) {
  const Result result = RunApp("D1 --out /proc/nowhere");
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstr("cannot make the output directory '/proc/nowhere'"));
}

TEST_F(TenonCdprTest, WhatNoRobotDoesEndsTheRun) {
  const auto ends = [&](const char* arguments, const char* reason) {
    const Result result =
        RunApp("D1 --controller pd --duration 2 --set forbid_slack=false " + std::string(arguments) + Out());
    EXPECT_EQ(result.exit_code, 3) << result.text;
    EXPECT_THAT(Read(out / "summary.json"), HasSubstr(reason));
  };
  ends("--set start_offset_m=[0,0,-2.5]", "the platform reaches");
  ends("--set start_offset_m=[0,0,1e30]", "m away from the middle of the anchors");
  ends("--set pd.stiffness_N_per_m=1e5 --set pd.damping_N_s_per_m=0 --set start_offset_m=[1,0,0]",
       "more than the 880 N that its winch holds");
}

TEST(TenonCdprListTest, ListsScenariosWithTheirDescriptions) {
  const Result result = RunApp("--list");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, HasSubstr("circle of 0.5 m radius in 10 s, four cables"));
}

TEST(TenonCdprListTest, HelpSaysWhatThereIs) {
  const Result result = RunApp("--help");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, AllOf(HasSubstr("--controller"), HasSubstr("--set"), HasSubstr("Exit codes")));
}

}  // namespace
}  // namespace tenon
