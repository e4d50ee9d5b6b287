// The claims that hold for each app that runs a robot, checked on its binary.

#include <tenon/systems/version.h>
#include <tenon/tests/apps/run_app.h>

#include <map>

namespace tenon::every_app_test {

namespace fs = std::filesystem;
using ::testing::AllOf, ::testing::ContainsRegex, ::testing::HasSubstr, ::testing::StartsWith;

struct App {
  std::string name, path;
  std::string scenario;                       ///< a scenario that ends without an error
  std::string description;                    ///< of this scenario
  std::string noise;                          ///< settings with which a run depends on random numbers
  std::map<std::string, std::string> limits;  ///< figures of the scenario and their limits, as printed
  std::vector<std::string> figures, signals, keys, blocks;
  friend void PrintTo(const App& app, std::ostream* out) { *out << app.name; }
};

struct EveryAppTest : test::AppTest, ::testing::WithParamInterface<App> {
  EveryAppTest() : AppTest(GetParam().path) {}
};

INSTANTIATE_TEST_SUITE_P(
    Apps, EveryAppTest,
    ::testing::Values(
        App{.name = "quadruped",
            .path = TENON_QUADRUPED,
            .scenario = "stand",
            .description = "holds its stance",
            .noise = "--set sensors.encoders.angle_noise_rad=1e-4 --set "
                     "'random_forces=[{lower_N: 10, upper_N: 35, period_s: 0.1}]'",
            .limits = {{"torque_max_N_m", "(at most 60)"},
                       {"torque_beyond_drive_max_N_m", "(at most 0)"},
                       {"foot_depth_max_m", ""},
                       {"leg_clearance_min_m", "(at least -0.005)"},
                       {"trunk_clearance_min_m", ""},
                       {"ground_clearance_min_m", ""}},
            .figures = {"robot", "height_min_m", "height_end_m", "drift_m", "tilt_max_rad", "torque_max_N_m",
                        "foot_force_max_N", "evaluations"},
            .signals = {"loop.world.plant.foot_forces.front_left.z [N]",
                        "loop.world.imu.measurement.specific_force_B.z [m/s^2]"},
            .keys = {"atol_bristles"},
            .blocks = {"cluster_loop", "encoders"}},
        App{.name = "guide_dog",
            .path = TENON_GUIDE_DOG,
            .scenario = "C3",
            .description = "C3",
            .noise = "--set sensors.foot_force.noise_ratio=0.1",
            .limits = {{"person_clearance_min_m", "(at least 0)"}, {"obstacle_clearance_min_m", ""}},
            .figures = {"observer", "robot", "slack_ratio", "tension_mean_N", "tension_max_N",
                        "distance_mean_m", "distance_min_m", "distance_max_m", "stop_delay_s",
                        "heading_error_deg", "force_estimate_mean_N", "force_estimate_error_rms_N",
                        "com_error_max_m", "foot_error_max_m", "grf_error_mean_N", "qp_failures"},
            .signals = {"loop.leash.leash.tension [N]", "loop.person.person.hand_W.z [m]",
                        "loop.supervisor.status.mode"},
            .keys = {"felt_tension_N: 5", "threshold_N: 50"},
            .blocks = {"supervisor", "admittance"}},
        App{.name = "cdpr",
            .path = TENON_CDPR,
            .scenario = "D1",
            .description = "circle of 0.5 m radius in 10 s, four cables",
            .noise = "--set path.radius_m=0.4",
            .limits = {{"tension_max_N", "(at most 880)"},
                       {"command_max_N", "(at most 800)"},
                       {"cable_distance_min_m", "(at least 0.005)"},
                       {"cable_platform_angle_min_rad", ""},
                       {"floor_clearance_min_m", ""},
                       {"turn_max_rad", ""}},
            .figures = {"controller", "tension_min_N", "tension_max_N", "command_min_N", "command_max_N",
                        "tension_rate_rms_N_per_s", "euler_oscillation_rms_rad", "acceleration_rms_m_per_s2",
                        "tracking_error_rms_m", "settling_time_s", "mpc_time_median_us", "mpc_time_p99_us",
                        "mpc_fallbacks"},
            .signals = {"loop.plant.cables.tension.0 [N]", "loop.command.0 [N]"},
            .keys = {"pose_rate_hz: 200"},
            .blocks = {"cluster_loop", "mpc"}}),
    [](const auto& info) { return info.param.name; });

TEST_P(EveryAppTest, WritesSummarySignalsScenarioReportAndGraph) {
  const auto& [name, path, scenario, description, noise, limits, figures, signals, keys, blocks] = GetParam();
  const std::string text = Run(scenario + " --duration 0.3 --seed 7 --graph " + Write("graph.dot", ""));
  for (const char* key :
       {"case", "seed", "finished", "fell", "end_reason", "simulated_s", "wall_s", "real_time_factor"})
    EXPECT_THAT(Summary(), HasSubstr("\"" + std::string(key) + "\": "));
  for (const std::string& key : figures) EXPECT_THAT(Summary(), HasSubstr("\"" + key + "\": "));
  EXPECT_THAT(Summary(), HasSubstrs("\"case\": \"" + scenario + "\"", "\"seed\": 7", "\"finished\": true",
                                    "\"fell\": false", "\"simulated_s\": 0.3"));
  EXPECT_THAT(Signals(), HasSubstrs("time [s],", "\n0.3,"));
  for (const std::string& signal : signals) EXPECT_THAT(Signals(), HasSubstr(signal));
  for (const std::string& key : keys) EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstr(key));
  for (const std::string& block : blocks) EXPECT_THAT(ReadText(out / "graph.dot"), HasSubstr(block));
  EXPECT_THAT(Summary(), HasSubstr(std::string("\"tenon\": \"") + Version()));
  EXPECT_THAT(ReadText(out / "scenario.yaml"), StartsWith(std::string("# Tenon ") + Version() + "\n"));
  EXPECT_THAT(ReadText(out / "report.html").substr(0, 500),
              HasSubstrs(Version(), "<title>" + scenario + ": ", description));
  EXPECT_LT(fs::file_size(out / "report.html"), 2e6);
  const std::size_t beside = Summary().find("\"limits\"");
  for (const auto& [figure, limit] : limits) {
    EXPECT_THAT(Summary().substr(beside), HasSubstr("\"" + figure + "\": {"));
    EXPECT_THAT(text, HasSubstr(limit)) << figure;
  }
}

TEST_P(EveryAppTest, RepeatsARunFromItsWrittenScenario) {
  Run(GetParam().scenario + " --duration 0.2 " + GetParam().noise);
  const std::string first = Signals();
  const std::string scenario = (out / "scenario.yaml").string();
  EXPECT_EQ(test::RunCommand(app + " " + scenario + Out() + "/again").exit_code, 0);
  EXPECT_TRUE(ReadText(out / "again" / "signals.csv") == first);  // EXPECT_EQ would print both files
}

TEST_P(EveryAppTest, ListsScenariosWithTheirDescriptions) {
  const test::Result list = test::RunCommand(app + " --list");
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.text, HasSubstrs(GetParam().scenario, GetParam().description));
}

TEST_P(EveryAppTest, RefusesBadUsage) {
  const std::string& scenario = GetParam().scenario;
  ExpectRefused({{"", "no scenario given"},
                 {scenario + "x", "'" + scenario + "x'"},
                 {"missing.yaml", "'missing.yaml'"},
                 {scenario + " --frobnicate$(printf '\\033')", "--frobnicate\\x1b"},
                 {scenario + " --duration -1", "--duration: -1"},
                 {scenario + " --seed -1", "--seed: -1"},
                 {scenario + " --set pd", "--set pd: "},
                 {scenario + " --graph /tmp/x.bmp", ".svg or .dot"},
                 {scenario + " --set app=tenon-walk", "run tenon-walk " + scenario}});
  ExpectSettingsRefused(scenario, {"duration_s=-3", "log_rate_hz=0", "seed=010", "seed=18446744073709551616",
                                   "robot=dogbt", "integrator.rtol=1e308"});
}

TEST_P(EveryAppTest, RefusesAnOutputDirectoryThatCannotBeMade) {
  const test::Result result = test::RunCommand(app + " " + GetParam().scenario + " --out /proc/nowhere");
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstr("'/proc/nowhere'"));
}

/// The runs of one app whose verdict depends on whether the robot follows its path.
struct PathRun {
  std::string name, app, run, tolerance, without_path;
};
struct PathTest : test::AppTest, ::testing::WithParamInterface<PathRun> {
  PathTest() : AppTest(GetParam().app) {}
};

INSTANTIATE_TEST_SUITE_P(
    Apps, PathTest,
    ::testing::Values(
        // A steady push carries the robot backwards on ice, although it never falls.
        PathRun{"quadruped", TENON_QUADRUPED,
                "flat --duration 9 --set terrain.friction=0.03 --set walk.friction=0.03 --set "
                "'forces=[{force_N: [-5, 0, 0], duration_s: 100}]' --set walk.path_tolerance=0.9",
                "walk.path_tolerance=0.1", "trot_in_place --duration 1"},
        PathRun{"guide_dog", TENON_GUIDE_DOG, "C1 --duration 2", "walk.path_tolerance=1e-4", ""},
        PathRun{"cdpr", TENON_CDPR,
                "D1 --controller pd --duration 2 --set forbid_slack=false --set "
                "'gusts=[{force_N: [0, 60, 0], start_s: 0.5, duration_s: 1}]'",
                "path_tolerance=0.001", "D2 --duration 0.2"}),
    [](const auto& info) { return info.param.name; });

TEST_P(PathTest, ARobotThatLeavesItsPathIsNotFinished) {
  const auto& [name, path, run, tolerance, without_path] = GetParam();
  Run(run);
  EXPECT_THAT(Summary(), HasSubstr("\"followed\": true"));
  Run(run + " --set " + tolerance, 3);
  EXPECT_THAT(Summary(), AllOf(HasSubstrs("\"finished\": false", "\"fell\": false", "\"followed\": false"),
                               ContainsRegex("\"end_reason\": *\"[^\"]*path")));
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("but the path was not followed"));
  if (without_path.empty()) return;
  Run(without_path);
  EXPECT_THAT(Summary(), HasSubstr("\"followed\": null"));
}

}  // namespace tenon::every_app_test
