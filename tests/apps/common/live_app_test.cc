#include <tenon/tests/apps/common/live_app.h>

#include <fstream>
#include <string>
#include <vector>

namespace tenon::test::live_app_test {
namespace {

using ::testing::HasSubstr;

struct LiveApp {
  std::string app;
  const char* scenario;
  std::vector<const char*> commands;
  friend void PrintTo(const LiveApp& live, std::ostream* out) { *out << live.scenario; }
};

class LiveAppsTest : public LiveAppTest, public ::testing::WithParamInterface<LiveApp> {};

TEST_P(LiveAppsTest, IsReplayedBitForBit) {
  const auto& [app, scenario, commands] = GetParam();
  Start(app + " " + scenario + " --live --duration 2" + Out());
  EXPECT_EQ(Command(R"({"command":"take"})"), Json({{"ok", true}}));
  for (const char* command : commands) {
    EXPECT_TRUE(Command(command).contains("ok")) << command;
    EXPECT_TRUE(Command(R"({"command":"tick"})").contains("ok"));  // so that each comes at a time of its own
  }
  EXPECT_TRUE(Command(R"({"command":"rate","value":null})").contains("ok"));
  EXPECT_TRUE(Command(R"({"command":"resume"})").contains("ok"));
  EXPECT_EQ(End(), 0);
  const std::filesystem::path again = out / "again";
  const Result replay = RunCommand(app + " " + scenario + " --replay " + (out / "live.jsonl").string() +
                                   " --out " + again.string());
  EXPECT_EQ(replay.exit_code, 0) << replay.text;
  EXPECT_FALSE(Read(out / "signals.csv").empty());
  EXPECT_EQ(Read(out / "signals.csv"), Read(again / "signals.csv"));
}

// Shapes 0, 3 and 18 of the quadruped: its trunk, a thigh's link and a foot.
INSTANTIATE_TEST_SUITE_P(
    Apps, LiveAppsTest,
    ::testing::Values(
        LiveApp{TENON_QUADRUPED,
                "flat",
                {R"({"command":"drive","velocity":[0.3,0.1,0.2]})", R"({"command":"gait","name":"crawl"})",
                 R"({"command":"pull","shape":18,"point_W":[-0.3,-0.2,0],"target_W":[-0.3,-0.3,0.2]})",
                 R"({"command":"pull","shape":18,"point_W":[0,0,0],"target_W":[-0.3,-0.4,0.2]})",
                 R"({"command":"release"})", R"({"command":"load","mass_kg":3})",
                 R"({"command":"parameter","path":"loop.locomotion.com_planner.blend","value":0.4})",
                 R"({"command":"posture","name":"squat"})"}},
        LiveApp{TENON_CDPR,
                "circle_8",
                {R"({"command":"load","mass_kg":1})",
                 R"({"command":"pull","shape":0,"point_W":[0.5,0,2],"target_W":[0.5,0,2.3]})",
                 R"({"command":"load","mass_kg":0})", R"({"command":"goal","position":[0.3,0.1,2.1]})"}},
        LiveApp{TENON_CDPR,
                "D1",
                {R"({"command":"goal","position":[0.3,0.1,2.1]})",
                 R"({"command":"goal","position":[0.2,-0.2,1.9]})"}},
        LiveApp{
            TENON_GUIDE_DOG,
            "C1",
            {R"({"command":"goal","position":[-1,1,0]})", R"({"command":"drive","velocity":[0.2,0,0]})"}}),
    [](const auto& info) { return std::string(info.param.scenario); });

using LiveQuadrupedTest = LiveAppTest;

TEST_F(LiveQuadrupedTest, GoesBackAndBranches) {
  Start(std::string(TENON_QUADRUPED) + " stand --live --duration 1.5" + Out());
  Command(R"({"command":"take"})");
  Command(R"({"command":"pause"})");
  for (int i = 0; i < 30; ++i) Command(R"({"command":"tick"})");  // well past the time to go back to
  Command(R"({"command":"load","mass_kg":4})");
  for (int i = 0; i < 30; ++i) Command(R"({"command":"tick"})");
  EXPECT_TRUE(Command(R"({"command":"back","to_s":0.01})").contains("ok"));
  Command(R"({"command":"load","mass_kg":2})");
  Command(R"({"command":"rate","value":null})");
  Command(R"({"command":"resume"})");
  EXPECT_EQ(End(), 0);
  const Result replay = RunCommand(std::string(TENON_QUADRUPED) + " stand --replay " +
                                   (out / "live.jsonl").string() + " --out " + (out / "again").string());
  EXPECT_EQ(replay.exit_code, 0) << replay.text;
  EXPECT_EQ(Read(out / "signals.csv"), Read(out / "again" / "signals.csv"));
  EXPECT_EQ(Read(out / "live.jsonl").find("\"live_load.mass\":[4.0]"), std::string::npos);
}

TEST_F(LiveQuadrupedTest, SavesAScenarioThatStartsAsItWasTuned) {
  Start(std::string(TENON_QUADRUPED) + " stand --live" + Out());
  Command(R"({"command":"take"})");
  Command(R"({"command":"parameter","path":"loop.world.monitor.max_tilt","value":0.7})");
  const Json saved = Command(R"({"command":"save"})");
  EXPECT_TRUE(Command(R"({"command":"stop"})").contains("ok"));
  EXPECT_EQ(End(), 130);  // as Ctrl-C
  EXPECT_TRUE(std::filesystem::exists(out / "report.html"));
  const std::string yaml = saved.at("yaml");
  EXPECT_THAT(yaml, HasSubstr("loop.world.monitor.max_tilt"));
  std::ofstream(out / "tuned.yaml") << yaml;
  const Result run = RunCommand(std::string(TENON_QUADRUPED) + " " + (out / "tuned.yaml").string() +
                                " --duration 0.1 --out " + (out / "tuned").string());
  EXPECT_EQ(run.exit_code, 0) << run.text;
}

TEST_F(LiveQuadrupedTest, AResetWritesTheRunOfTheNewSeed) {
  Start(std::string(TENON_QUADRUPED) + " stand --live --duration 0.3" + Out());
  Command(R"({"command":"take"})");
  EXPECT_TRUE(Command(R"({"command":"reset","seed":5})").contains("ok"));
  EXPECT_EQ(End(), 0);
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("\"seed\": 5"));
  EXPECT_THAT(Read(out / "live.jsonl"), HasSubstr("\"seed\":5"));
}

class LiveUsageTest : public UsageTest {};

TEST_P(LiveUsageTest, ExitCode2) {
  ExpectExitCode2WithItsMessage(TENON_QUADRUPED);
}
INSTANTIATE_TEST_SUITE_P(
    Arguments, LiveUsageTest,
    ::testing::Values(
        BadUsage{"flat --live=99999", "a port from 1 to 65535"},
        BadUsage{"flat --live --compare", "--compare"}, BadUsage{"flat --live-address 0.0.0.0", "--live"},
        BadUsage{"flat --replay nowhere.jsonl", "cannot read the recording 'nowhere.jsonl'"},
        BadUsage{"stand --set 'parameters={loop.world.monitor.max_tild: [1]}'",
                 "there is no Parameter 'loop.world.monitor.max_tild' in this diagram; did you mean "
                 "'loop.world.monitor.max_tilt'?"},
        BadUsage{"stand --set 'parameters={loop.world.monitor.max_tilt: [1, 2]}'", "has 1 elements"}));

}  // namespace
}  // namespace tenon::test::live_app_test
