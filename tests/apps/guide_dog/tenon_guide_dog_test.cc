// Runs the binary as its users do: what it writes, what it refuses.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fstream>

namespace tenon::tenon_guide_dog_test {
namespace {

namespace fs = std::filesystem;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_GUIDE_DOG) + " " + arguments);
}

using TenonGuideDogTest = test::AppTest;

TEST_F(TenonGuideDogTest, FiguresCountFromWhenTheWalkIsJudged) {
  ASSERT_EQ(RunApp("C3 --duration 0.3 --set walk.judged_from_s=0.5" + Out()).exit_code, 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"com_error_max_m\": null"));
}

/// The mean counts from when the person is led at the desired tension, 104 N for this robot and not 30: from
/// there on it would be 102 N.
TEST_F(TenonGuideDogTest, FiguresAreOfTheTensionsThatAreScaled) {
  ASSERT_EQ(RunApp("C1 --set robot=b2 --set scale_forces=true --duration 5" + Out()).exit_code, 0);
  const std::string summary = Read(out / "summary.json");
  EXPECT_THAT(summary, HasSubstr("\"tension_mean_N\": 11"));
  EXPECT_THAT(summary, HasSubstr("\"tension_max_N\": 1"));
}

TEST_F(TenonGuideDogTest, ARobotThatLeavesItsPathIsNotFinished) {
  const Result follows = RunApp("C1 --duration 2" + Out());
  EXPECT_EQ(follows.exit_code, 0) << follows.text;
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"followed\": true"));
  const Result leaves = RunApp("C1 --duration 2 --set walk.path_tolerance=1e-4" + Out());
  EXPECT_EQ(leaves.exit_code, 3) << leaves.text;
  EXPECT_THAT(Read(out / "summary.json"),
              AllOf(HasSubstr("\"finished\": false"), HasSubstr("\"followed\": false"),
                    HasSubstr("the path was not followed: the robot ")));
}

TEST_F(TenonGuideDogTest, SaysWhichDisturbancesNeverAct) {
  const std::string note = "forces.0 never acts: start_s = 5, and the run ends at 0.1 s";
  const Result result =
      RunApp("C1 --duration 0.1 --set 'forces=[{force_N: [9, 0, 0], start_s: 5, duration_s: 1}]'" + Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("warning: " + note));
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr(note));
}

TEST_F(TenonGuideDogTest, WarnsOfWhatTheUrdfLacks) {
  const fs::path home = test::TemporaryPath("guide_dog_robot");
  fs::create_directories(home);
  std::string urdf = Read(TENON_ROBOTS_DIR "/a1.urdf");
  const std::string link = "<link name=\"trunk\">";
  urdf.insert(urdf.find(link) + link.size(),
              "<visual><geometry><mesh filename=\"no.stl\"/></geometry></visual>");
  std::ofstream(home / "a1.urdf") << urdf;
  std::ofstream(home / "a1.yaml") << Read(TENON_ROBOTS_DIR "/a1.yaml");
  const Result run = RunApp("C1 --duration 0.1 --set robot=" + (home / "a1.yaml").string() + Out());
  EXPECT_EQ(run.exit_code, 0) << run.text;
  EXPECT_THAT(run.text, AllOf(HasSubstr("warning: "), HasSubstr("the mesh 'no.stl' is not found")));
  fs::remove_all(home);
}

TEST_F(TenonGuideDogTest, WritesSummarySignalsScenarioReportAndGraph) {
  const Result result = RunApp("C3 --duration 0.3 --seed 7" + Out() + " --graph " + out.string() + ".dot");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string summary = Read(out / "summary.json");
  for (const char* key : {"case",
                          "seed",
                          "observer",
                          "finished",
                          "fell",
                          "end_reason",
                          "simulated_s",
                          "wall_s",
                          "real_time_factor",
                          "robot",
                          "tension_mean_N",
                          "tension_max_N",
                          "distance_mean_m",
                          "distance_min_m",
                          "distance_max_m",
                          "stop_delay_s",
                          "heading_error_deg",
                          "force_estimate_mean_N",
                          "force_estimate_error_rms_N",
                          "com_error_max_m",
                          "foot_error_max_m",
                          "grf_error_mean_N",
                          "qp_failures"}) {
    EXPECT_THAT(summary, HasSubstr("\"" + std::string(key) + "\": "));
  }
  EXPECT_THAT(summary,
              AllOf(HasSubstr("\"case\": \"C3\""), HasSubstr("\"seed\": 7"),
                    HasSubstr("\"observer\": \"hybrid\""), HasSubstr("\"heading_error_deg\": null")));
  EXPECT_THAT(Read(out / "signals.csv"),
              AllOf(HasSubstr("loop.leash.leash.tension [N]"), HasSubstr("loop.person.person.hand_W.z [m]"),
                    HasSubstr("loop.supervisor.status.mode"), HasSubstr("\n0.3,")));
  EXPECT_THAT(Read(out / "scenario.yaml"),
              AllOf(HasSubstr("felt_tension_N: 5"), HasSubstr("threshold_N: 50")));
  EXPECT_THAT(Read(out / "report.html"), AllOf(HasSubstr("path of the person"), HasSubstr("obstacle 0")));
  EXPECT_THAT(Read(out.string() + ".dot"), AllOf(HasSubstr("supervisor"), HasSubstr("admittance")));
  std::filesystem::remove(out.string() + ".dot");
}

TEST_F(TenonGuideDogTest, WrittenScenarioRepeatsTheRun) {
  ASSERT_EQ(RunApp("C1 --duration 0.2 --set sensors.foot_force.noise_ratio=0.1" + Out()).exit_code, 0);
  const std::string first = Read(out / "signals.csv");
  const Result again = RunApp((out / "scenario.yaml").string() + Out() + "/again");
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_TRUE(Read(out / "again" / "signals.csv") == first);  // too long to print
}

TEST_F(TenonGuideDogTest, WalksByTheEstimatedState) {
  const Result result = RunApp("C2 --duration 2 --set walk.state=estimated" + Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "signals.csv"), HasSubstr("loop.estimator.estimate"));
}

TEST_F(TenonGuideDogTest, ListsItsScenarios) {
  const Result result = RunApp("--list");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* name : {"C1", "C1-sine", "C2", "C3"}) EXPECT_THAT(result.text, HasSubstr(name));
}

TEST_F(TenonGuideDogTest, RefusesWhatItCannotRun) {
  const auto refuses = [&](const std::string& arguments, const char* a, const char* b) {
    const Result result = RunApp(arguments + Out());
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.text, AllOf(HasSubstr(a), HasSubstr(b))) << arguments;
  };
  refuses("flat", "is not a scenario of", "run tenon-quadruped flat");
  refuses("C1 --set app=tenon-cdpr", "another app", "tenon-guide-dog");
  refuses("C1 --set duration_s=0", "duration_s", "positive");
  refuses("C1 --set walk.judged_from_s=76", "--set walk.judged_from_s=76", "the run ends at 75 s");
  refuses("C1 --set fall.min_height_ratio=2", "fall", "min_height_ratio = 2");
  refuses("C1 --set log_rate_hz=0", "log_rate_hz", "a rate of 0 Hz");
  refuses("C1 --set person.phases.1.speed_m_per_s=-1", "phases.1", "negative");
  refuses("C1 --set leash.stiffness=3", "leash", "stiffness_N_per_m");
  refuses("C3 --set surroundings.obstacles.0.radius_m=0", "obstacles.0", "positive radius");
  refuses("C1 --set supervisor.release_N=60", "release = 60 N", "threshold = 50 N");
}

}  // namespace
}  // namespace tenon::tenon_guide_dog_test
