// The command line of tenon-cdpr, its output files and its exit codes.

#include <tenon/systems/version.h>
#include <tenon/tests/apps/run_app.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <iomanip>
#include <numbers>

namespace tenon::tenon_cdpr_test {

namespace fs = std::filesystem;
using test::Column, test::Result, test::RunCommand, ::testing::AllOf, ::testing::ContainsRegex,
    ::testing::Each, ::testing::Gt, ::testing::HasSubstr, ::testing::Not;

class TenonCdprTest : public test::AppTest {
 protected:
  TenonCdprTest() : AppTest(TENON_CDPR) {}
};

TEST_F(TenonCdprTest, ComparesTheControllers) {
  Run("D1 --compare --duration 0.3");
  for (const std::string controller : {"mpc_equilibrium", "mpc_zero", "pd"}) {
    EXPECT_THAT(Summary(), HasSubstr("\"" + controller + "\": {"));
    EXPECT_THAT(ReadText(out / controller / "signals.csv"), HasSubstr("loop.command.0 [N]"));
    EXPECT_THAT(ReadText(out / controller / "scenario.yaml"), HasSubstr(controller));
    EXPECT_THAT(ReadText(out / controller / "summary.json"),
                HasSubstr("\"controller\": \"" + controller + "\""));
  }
  EXPECT_THAT(Summary(), HasSubstr("\"mpc_fallbacks\": 0.0"));
}

TEST_F(TenonCdprTest, AReportWithoutItsScriptsIsExitCode5) {
  const Result result = RunCommand("TENON_JAVASCRIPT_DIR=/nowhere " TENON_CDPR " D1 --duration 0.1" + Out());
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstr("apt-get install libjs-"));
}

// A user's robot with two rings of six anchors.
TEST_F(TenonCdprTest, FliesARobotOfTwelveCables) {
  std::ostringstream file;
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
  const std::string robot = Write("twelve.yaml", file.str());
  for (const std::string controller : {"mpc_equilibrium", "pd"}) {
    Run("circle_6 --duration 1 --set robot=" + robot + " --controller " + controller);
    EXPECT_THAT(Column(out, "loop.plant.cables.tension.11 [N]"), Each(Gt(0)));
    EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("cable 11"));
  }
}

// From 0.125 kg to 30 t, without gains in the scenario. Two seconds of the platform's time t = sqrt(l / g),
// see CdprProfile.
TEST_F(TenonCdprTest, FliesRobotsOfAllSizesWithOneSetOfGains) {
  struct Flight {
    std::string robot, center, attitude;
    double radius, t;
  };
  for (const Flight& flight :
       {Flight{"segesta", "[0, 0, 0.5]", " --set 'path.attitude_rad=[0, 0, 0]'", 0.1, 0.32},
        Flight{"fast", "[0, 0, 140]", "", 30, 5.7}}) {
    Run(fmt::format(
        "circle --duration {} --set robot={} --set 'path.center_m={}' --set path.radius_m={} --set "
        "path.period_s={} --set path.ramp_s={}{}",
        4 * flight.t, flight.robot, flight.center, flight.radius, 13 * flight.t, 0.65 * flight.t,
        flight.attitude));
    EXPECT_LT(nlohmann::json::parse(Summary())["tracking_error_rms_m"].get<double>(), 0.01 * flight.radius)
        << flight.robot;
  }
}

// A platform of 1 kg cannot pull cables from the reels of RoboCrane.
TEST_F(TenonCdprTest, SaysThatWinchesCannotPayOutFastEnough) {
  EXPECT_THAT(
      Run("circle --duration 8 --set 'robot={file: robocrane, mass_kg: 1, inertia_kg_m2: [1, 1, 1]}' --set "
          "'path.center_m=[0, 0, 1.5]' --set path.radius_m=0.3 --set forbid_slack=false",
          3),
      HasSubstrs("warning: robot.winch.reel_damping_N_s_per_m = 180 ", "cable "));
  EXPECT_THAT(Summary(), HasSubstr("the path was not followed"));
}

TEST_F(TenonCdprTest, RefusesAProfileOfAWalkingRobot) {
  ExpectSettingsRefused("circle", {"profile=standard"});
}

TEST_F(TenonCdprTest, FliesOnSimbodysDynamics) {
  const auto error = [&](const std::string& dynamics) {
    Run("D1 --duration 0.5 --set dynamics=" + dynamics);
    return nlohmann::json::parse(Summary()).at("tracking_error_rms_m").get<double>();
  };
  const double closed_form = error("closed_form"), simbody = error("simbody");
  EXPECT_NE(simbody, closed_form);
  EXPECT_NEAR(simbody, closed_form, 1e-8 * closed_form);
}

TEST_F(TenonCdprTest, FliesWithASwingingArm) {
  Run("D1-arm --duration 2");
  const std::vector<double> angle = Column(out, "loop.plant.added_positions.forearm [rad]");
  EXPECT_NEAR(angle.front(), 0.5, 1e-9);
  EXPECT_GT(*std::ranges::max_element(angle), 0.7);
  EXPECT_NEAR(Column(out, "loop.plant.added_wrench.force_W.z [N]").back(), -1.3 * 9.81, 2);
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("upper_arm"));
}

TEST_F(TenonCdprTest, FliesWithAKnownArm) {
  const auto error = [&](const std::string& options) {
    Run("D1-arm --duration 3 --controller pd_feedforward" + options);
    return nlohmann::json::parse(Summary()).at("tracking_error_rms_m").get<double>();
  };
  const double unknown = error("");
  EXPECT_LT(error(" --set known_additions=true"), 0.8 * unknown);
  ExpectRefused({{"D1-arm --controller pd --set known_additions=true", "pd_feedforward"}});
}

// Sagging cables, pulleys, drums of several layers and differential winches change the tensions.
TEST_F(TenonCdprTest, FliesWithModelsOfCablesAndWinches) {
  Run("D1 --duration 0.5");
  const std::vector<double> ideal = Column(out, "loop.plant.cables.tension.0 [N]");
  for (const std::string run :
       {"D1-sag", "circle_8-pulleys",
        "D1 --set 'robot={file: cdpr_4, winch: {drum: {radius_m: 0.036, cable_diameter_m: 0.005, "
        "turns_per_layer: 10, cable_length_m: 10.8}, "
        "differential: {pairs: [[0, 1], [2, 3]], motor_tension_max_N: 75}}}'"}) {
    Run(run + " --duration 0.5");
    EXPECT_NE(Column(out, "loop.plant.cables.tension.0 [N]"), ideal);
  }
  const auto winch = [](const std::string& text) {
    return "D1 --set 'robot={file: cdpr_4, winch: {" + text + "}}'";
  };
  ExpectRefused({{winch("pulley_radius_m: -0.04"), "winch.pulley_radius_m"},
                 {winch("pulley_radius_m: 4"), "path: "},
                 {winch("pulley_radius_m: 4") + " --set known_pulleys=false", "block 'plant'"},
                 {winch("pulley_radius: 0.04"), "pulley_radius_m"},
                 {winch("drum: {radius_m: 0.036}"), "cable_diameter_m"}});
}

// Delays and errors between controller and plant change the commands of each controller.
TEST_F(TenonCdprTest, FliesWithTheHardwareOfARobot) {
  for (const std::string controller :
       {"mpc_equilibrium", "mpc_zero", "lqr", "pd", "pd_feedforward", "pd_offset_free"}) {
    const std::string run = "D1 --duration 0.5 --controller " + controller;
    Run(run);
    const std::vector<double> ideal = Column(out, "loop.command.0 [N]");
    Run(run + " --set hardware=standard");
    EXPECT_NE(Column(out, "loop.command.0 [N]"), ideal);
    EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstr("hardware: standard"));
  }
  ExpectSettingsRefused("D1", {"load.bandwidth_rad_per_s=300", "hardware=perfect"});
  const auto hardware = [](const std::string& text) {
    return "D1 --set 'hardware={file: standard, " + text + "}'";
  };
  ExpectRefused({{hardware("link: {delay_s: 0.001, jitter_s: 0.002}"), ": hardware.link.jitter_s: "},
                 {hardware("winches: {gain_deviation: 2}"), "gain_deviation"},
                 {hardware("sensors: {imu: {misalignment_rad: -1}}"), "misalignment_rad"}});
}

TEST_F(TenonCdprTest, BrokenLimitIsExitCode3) {
  Run("D1 --controller pd --duration 5 --set pd.stiffness_N_per_m=60000 --set pd.damping_N_s_per_m=1", 3);
  EXPECT_THAT(Summary(), HasSubstrs("\"finished\": false", "is slack"));
}

TEST_F(TenonCdprTest, NumericalFailureIsExitCode4AndKeepsWhatWasWritten) {
  Run("D1 --controller pd --duration 5 --set pd.stiffness_N_per_m=1e300 --set forbid_slack=false --set "
      "integrator.rtol=1e-14 --set integrator.atol=1e-300 --set max_tension_ratio=2",
      4);
  EXPECT_THAT(Summary(), HasSubstrs("\"finished\": false", "the integrator fails"));
  EXPECT_THAT(Signals(), HasSubstr("\n0,"));
}

// One of each kind: a key, a name, ranges here and in the robot's file, and found when the diagram is made.
TEST_F(TenonCdprTest, RefusesBadSettings) {
  ExpectSettingsRefused(
      "D1", {"pd.stifness_N_per_m=1", "controller=mpc", "mpc.mass_error=-1", "mpc.horizon_s=0.015",
             "mpc.num_steps=1000", "noise.imu_rate_hz=-5", "robot.mass=6", "integrator.atol=1e308",
             "path.attitudes_rad=[[0,0,0]]", "path.tension_aim_N=50"});
  ExpectSettingsRefused("turn_8", {"path.attitude_rad=[0,0,0]"});
  ExpectSettingsRefused("gust", {"gusts.0.duration_s=0"});
  ExpectSettingsRefused("pendulum", {"hanging_load.swing_m=[1,1]"});
}

// The message names the key that contradicts another one, or that a map lacks.
TEST_F(TenonCdprTest, RefusesSettingsThatDoNotFitTogether) {
  ExpectRefused(
      {{"D1 --controller pd --compare", "--controller excludes --compare"},
       {"D1 --set mpc=null", ": mpc: "},
       {"D1 --set 'payload={attach_s: 2, release_s: 1}'", ": payload.release_s: "},
       {"D1 --set 'payload={mass_kg: 1, position_m: [1e6, 0, 0]}'", ": payload.position_m.0: "},
       {"D1 --set path.center_m=[0,0,5]", "D1.yaml:10:3: path: "},
       {"D1 --set path.kind=hold", "D1.yaml:10:3: path: "},
       {"D1 --set path.kind=waypoints", "D1.yaml:10:3: path: "},
       {"D1 --set path.kind=spline --set 'path.points_m=[[0,0,2],[0,0,1]]'", ": path.points_m: "},
       {"D1 --set 'path={kind: spline, points_m: [[0,0,2],[0,0,1]], times_s: [1, 1]}'", ": path.times_s.1: "},
       {"D1 --set 'path={kind: line, points_m: [[0,0,2],[0,0,2.1]], times_s: [0, 1e6]}'", ": path.times_s: "},
       {"turn_8 --set path.attitudes_rad=[[0,0,0]]", "turn_8.yaml:10:18: path.points_m: "},
       {"waypoints --set path.attitude_rad=[0,0,0]", "waypoints.yaml:10:3: path: "},
       {"waypoints --set path.waypoints.0.travel_s=1", "waypoints.yaml:12:7: path.waypoints.0: "},
       {"D1 --set 'report.plots=[{title: speed}]'", ": report.plots.0: "},
       {"D1 --set \"report.events=[$(seq -s, 1001)]\"", ": report.events: "},
       {"D1 --set mpc.weights.tension_per_N2=[1,2,3]", ": mpc.weights.tension_per_N2: "},
       {"D1 --set robot.cables=[1,2,3]", ": robot.cables.0: "}});
}

TEST_F(TenonCdprTest, AMotionThatNoRobotPerformsEndsTheRun) {
  const std::string flight = "D1 --controller pd --duration 2 --set forbid_slack=false ";
  for (const auto& [settings, reason] :
       {std::pair<std::string, std::string>{"--set start_offset_m=[0,0,-2.5]", "the platform reaches"},
        {"--set start_offset_m=[0,0,90]", "m away from the middle of the anchors"},
        {"--set pd.stiffness_N_per_m=1e5 --set pd.damping_N_s_per_m=0 --set start_offset_m=[1,0,0]",
         "its winch holds 880 N"}}) {
    Run(flight + settings, 3);
    EXPECT_THAT(Summary(), HasSubstr(reason));
  }
}

// Cables that touch, turns beyond their reach and loads in the floor do not end a run: the verdict names
// them.
TEST_F(TenonCdprTest, ARunThatNoRobotPerformsIsNotFinished) {
  for (const auto& [flight, reason] : {
           std::pair<std::string, std::string>{"waypoints --duration 5.5 --set cable_diameter_m=0.3",
                                               "two cables touched: the axes of "},
           {"D1 --controller pd --duration 1 --set forbid_slack=false --set start_turn_rad=[0,0,2.2]",
            "the platform turned beyond the reach of its cables: by 2.2 rad"},
           {"pendulum --duration 0.3 --set path.center_m=[0,0,0.9] --set 'path.points_m=[[0,0,0.9]]'",
            "platform, load or cables went through the floor: the hanging load by "},
           {"D1 --controller pd --duration 0.1 --set 'robot={file: cdpr_4, obstacles: [{from_m: [0.5, 0, 0], "
            "to_m: [0.5, 0, 1.9], radius_m: 0.02}]}'",
            "the robot ran into an obstacle: the platform by "},
       }) {
    Run(flight, 3);
    EXPECT_THAT(Summary(), HasSubstrs("\"finished\": false", reason));
    EXPECT_NE(ReadText(out / "report.html").find("but " + reason), std::string::npos);
  }
}

// A figure beyond its limit is printed with enough digits to differ from the limit: 4.9999 mm and 5 mm. Both
// are in m, as the figures are.
TEST_F(TenonCdprTest, AFigureAndItsLimitAreToldApart) {
  const std::string flight = "waypoints --duration 5.5 --set log_rate_hz=10 ",
                    key = "\"cable_distance_min_m\": ";
  Run(flight);
  const std::string summary = Summary();
  const double least = std::stod(summary.substr(summary.find(key) + key.size()));
  std::ostringstream diameter;
  diameter << std::setprecision(12) << least + 1e-7;
  const std::string text = Run(flight + "--set cable_diameter_m=" + diameter.str(), 3);
  const auto expect_less = [&](const char* from, const char* format) {
    double value = 0, limit = 0;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << text;
    char unit = 0;
    ASSERT_EQ(std::sscanf(text.c_str() + at, format, &value, &limit, &unit), 3) << text.substr(at, 80);
    EXPECT_LT(value, limit);
  };
  expect_less(" were ", " were %lf m apart, less than %lf %c");
  expect_less("cable_distance_min_m", "cable_distance_min_m %lf m (at least %lf%c");
}

// The platform rests while it dwells, passes the other waypoints at the given speeds, and turns as given.
TEST_F(TenonCdprTest, FliesAlongWaypoints) {
  Run("waypoints --duration 12 --set log_rate_hz=100");
  const std::string reference = "loop.reference.reference.";
  const auto z = Column(out, reference + "position.z [m]"), y = Column(out, reference + "position.y [m]");
  const auto yaw = Column(out, reference + "euler.z [rad]");
  const auto speed = Column(out, reference + "velocity.z [m/s]");
  EXPECT_NEAR(z[100], 1.6, 1e-9);  // at t = 1 s
  EXPECT_NEAR(yaw[100], 0, 1e-6);
  const std::size_t passed = 100 + 400;  // after 1 m at 0.25 m/s
  EXPECT_NEAR(y[passed], 0.8, 1e-3);
  EXPECT_NEAR(yaw[passed], 0.3, 1e-3);
  EXPECT_LT(speed[passed], -0.01) << "it passes without a stop";
  for (std::size_t i = passed + 300; i <= passed + 500; i += 50) {
    EXPECT_NEAR(z[i], 0.9, 1e-9) << i;
    EXPECT_NEAR(speed[i], 0, 1e-9) << i;
  }
  for (std::size_t i = 2; i < z.size(); ++i)
    EXPECT_LT(std::abs(z[i] - 2 * z[i - 1] + z[i - 2]), 1.5e-4)
        << i;  // the acceleration stays below 1.5 m/s^2
}

// The run copies the table next to its scenario.yaml, so that the directory can be moved.
TEST_F(TenonCdprTest, FliesAlongAPathFromAFile) {
  const fs::path home = out.string() + "_home";
  Write("way.csv", "t, x, y, z\r\n0,0,0,2\r\n0.3,0.01,0,2\r\n1,0.1,0.1,1.9\r\n");
  Run(Write("own.yaml", "extends: scan\npath: {file: way.csv}\nduration_s: 0.3\n"));
  EXPECT_NEAR(Column(out, "loop.reference.reference.position.x [m]").back(), 0.01, 1e-12);
  const std::string first = Signals();
  fs::rename(out, home);
  fs::remove(home / "way.csv");
  Run((home / "scenario.yaml").string());
  EXPECT_EQ(Signals(), first);
  fs::remove_all(home);
}

// Spreadsheets write a byte-order mark.
TEST_F(TenonCdprTest, AByteOrderMarkInAPathFileIsSkipped) {
  Write("way.csv", "\xEF\xBB\xBFt,x,y,z\n0,0,0,2\n1,0.1,0.1,1.9\n");
  Run(Write("own.yaml", "extends: scan\npath: {file: way.csv}\nduration_s: 0.1\n"));
}

// A path of another kind inherits keys that it does not have.
TEST_F(TenonCdprTest, AnInheritedKeyIsPlacedInTheFileThatInheritsIt) {
  const std::string own =
      Write("own.yaml", "extends: turn_8\ncase: own\npath: {kind: hold, points_m: [[0, 0, 2]]}\n");
  EXPECT_THAT(Run(own, 2), AllOf(HasSubstr("own.yaml:3:7: path.attitudes_rad: "),
                                 ContainsRegex("inherited from .*/turn_8\\.yaml:1[0-9]:")));
}

TEST_F(TenonCdprTest, RefusesAWrongPathFileWithItsLine) {
  const std::string own = Write("own.yaml", "extends: scan\npath: {file: way.csv}\nduration_s: 0.1\n");
  for (const auto& [text, place] : {std::pair{"", "way.csv:1: "},
                                    {"t,x,y\n", "way.csv:1: "},
                                    {"t,x,y,z\n0,0,0,2\n", "way.csv:2: "},
                                    {"t,x,y,z\n0,0,0,2\n1,0,2\n", "way.csv:3: "},
                                    {"t,x,y,z\n0,0,0,2\n1,0,nan,2\n", "way.csv:3: 'nan'"},
                                    {"t,x,y,z\n0,0,0,2\n1,2 3,0,2\n", "way.csv:3: '2 3'"},
                                    {"t,x,y,z\n0,0,0,2\n1,0,,2\n", "way.csv:3: ''"},
                                    {"t,x,y,z\n0,0,0,2\n\n0,0,1,2\n", "way.csv:4: "},
                                    {"t,x,y,z\n0,0,0,2\n1,0,0,9\n", "path: "}}) {
    Write("way.csv", text);
    ExpectRefused({{own, place}});
  }
  fs::remove(out / "way.csv");
  ExpectRefused({{own, "own.yaml:2"}, {own, "way.csv"}});
}

TEST(TenonCdprKeysTest, ListsKeysWithTheirMeanings) {
  const Result keys = RunCommand(TENON_CDPR " --keys");
  EXPECT_EQ(keys.exit_code, 0);
  EXPECT_THAT(keys.text,
              AllOf(ContainsRegex("path\\.ramp_s +number +s +at least 0 +5 +[a-z]+"),
                    HasSubstr("faults[].at"), ContainsRegex("robot\\.mass_kg .* mass of the platform")));
  EXPECT_EQ(RunCommand(TENON_CDPR " D1 --keys").exit_code, 0);
  EXPECT_THAT(RunCommand(TENON_CDPR " D1 --keys --set robot=mine.yaml").text,
              HasSubstr("--set robot=mine.yaml: robot: "));
  EXPECT_EQ(RunCommand(TENON_CDPR " --version").text, std::string("tenon-cdpr ") + Version() + "\n");
  EXPECT_THAT(RunCommand(TENON_CDPR " --help").text, HasSubstrs("--controller", "Exit codes"));
}

TEST(TenonCdprCompletionTest, BashCompletesScenariosOptionsAndKeys) {
  const auto completed = [](const std::string& words, int at) {
    return RunCommand("bash -c 'source " TENON_COMPLETION "; COMP_WORDS=(" TENON_CDPR " " + words +
                      "); COMP_CWORD=" + std::to_string(at) + "; _tenon; echo ${COMPREPLY[@]}'")
        .text;
  };
  EXPECT_THAT(completed("circle_", 1), HasSubstr("circle_6 circle_8"));
  EXPECT_EQ(completed("--dur", 1), "--duration\n");
  EXPECT_EQ(completed("D1 --set path.ra", 3), "path.radius_m= path.ramp_s=\n");
  EXPECT_THAT(completed("D1 --set faults", 3), HasSubstr("faults.0.at="));
  EXPECT_EQ(completed("D1 --controller p", 3), "pd pd_feedforward pd_offset_free\n");
  EXPECT_EQ(completed("D1 --set robot = cog", 5), "cogiro\n") << "bash divides KEY=VALUE";
  EXPECT_EQ(completed("D1 --set controller =", 4).find("mpc_equilibrium mpc_zero"), 0U);
}

// The app offers all candidates; zsh keeps those that begin with the typed word.
TEST(TenonCdprCompletionTest, ZshCompletesScenariosOptionsAndKeys) {
  if (RunCommand("zsh --version").exit_code != 0) GTEST_SKIP() << "zsh is not installed";
  const auto offered = [](const std::string& words) {
    return RunCommand(
               "zsh -f -c 'compadd() { print -r -- \"$@\" }; _files() { print -r -- files \"$@\" }; "
               "complete() { words=(\"$@\"); CURRENT=$#words; PREFIX=$words[CURRENT]; "
               "source " TENON_ZSH_COMPLETION " }; complete " TENON_CDPR " " +
               words + "'")
        .text;
  };
  EXPECT_THAT(offered("circle_"), HasSubstrs(" circle_6 circle_8 ", "files -g *.yaml"));
  EXPECT_THAT(offered("--dur"), AllOf(HasSubstr("--duration"), Not(HasSubstr("circle_6"))));
  EXPECT_THAT(offered("D1 --set path.ra"), HasSubstrs("-S = -- ", " path.radius_m ", " faults.0.at "));
  EXPECT_THAT(offered("D1 --set robot=cog"), HasSubstr(" robot=cogiro "));
  EXPECT_THAT(offered("D1 --controller p"), HasSubstr(" pd_feedforward "));
  EXPECT_EQ(offered("D1 --out x"), "files\n");
}

}  // namespace tenon::tenon_cdpr_test
