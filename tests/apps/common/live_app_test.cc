#include <tenon/tests/apps/common/live_app.h>

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>

namespace tenon::test::live_app_test {

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
    EXPECT_TRUE(Command(R"({"command":"tick"})").contains("ok"));  // the next command gets another time
  }
  EXPECT_TRUE(Command(R"({"command":"rate","value":null})").contains("ok"));
  EXPECT_TRUE(Command(R"({"command":"resume"})").contains("ok"));
  EXPECT_EQ(End(), 0);
  ExpectSameReplay(app + " " + scenario);
}

// Shape 18 of the quadruped is a foot.
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
  for (int i = 0; i < 30; ++i) Command(R"({"command":"tick"})");  // go past the time that "back" returns to
  Command(R"({"command":"load","mass_kg":4})");
  for (int i = 0; i < 30; ++i) Command(R"({"command":"tick"})");
  EXPECT_TRUE(Command(R"({"command":"back","to_s":0.01})").contains("ok"));
  Command(R"({"command":"load","mass_kg":2})");
  Command(R"({"command":"rate","value":null})");
  Command(R"({"command":"resume"})");
  EXPECT_EQ(End(), 0);
  ExpectSameReplay(TENON_QUADRUPED " stand");
  EXPECT_EQ(ReadText(out / "live.jsonl").find("\"live_load.mass\":[4.0]"), std::string::npos);
}

TEST_F(LiveQuadrupedTest, SavesAScenarioWithTheTunedParameters) {
  Start(std::string(TENON_QUADRUPED) + " stand --live" + Out());
  Command(R"({"command":"take"})");
  Command(R"({"command":"parameter","path":"loop.world.monitor.max_tilt","value":0.7})");
  const Json saved = Command(R"({"command":"save"})");
  EXPECT_TRUE(Command(R"({"command":"stop"})").contains("ok"));
  EXPECT_EQ(End(), 130);  // like after Ctrl-C
  EXPECT_TRUE(std::filesystem::exists(out / "report.html"));
  const std::string yaml = saved.at("yaml");
  EXPECT_THAT(yaml, HasSubstr("loop.world.monitor.max_tilt"));
  const Result run = RunCommand(TENON_QUADRUPED " " + Write("tuned.yaml", yaml) + " --duration 0.1 --out " +
                                (out / "tuned").string());
  EXPECT_EQ(run.exit_code, 0) << run.text;
}

TEST_F(LiveQuadrupedTest, AResetWritesTheRunOfTheNewSeed) {
  Start(std::string(TENON_QUADRUPED) + " stand --live --duration 0.3" + Out());
  Command(R"({"command":"take"})");
  EXPECT_TRUE(Command(R"({"command":"reset","seed":5})").contains("ok"));
  EXPECT_EQ(End(), 0);
  EXPECT_THAT(Summary(), HasSubstr("\"seed\": 5"));
  EXPECT_THAT(ReadText(out / "live.jsonl"), HasSubstr("\"seed\":5"));
}

// The connections of the page get only a part of the descriptors that the process may open.
TEST_F(LiveQuadrupedTest, IdleConnectionsDoNotTakeTheDescriptorsOfFiles) {
  Start("sh -c 'ulimit -n 48; exec " TENON_QUADRUPED " stand --live --duration 5" + Out() + "'");
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::vector<int> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(::socket(AF_INET, SOCK_STREAM, 0));
    EXPECT_EQ(::connect(idle.back(), reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
  }
  EXPECT_TRUE(Command(R"({"command":"take"})").contains("ok"));
  EXPECT_TRUE(Command(R"({"command":"rate","value":null})").contains("ok"));
  EXPECT_EQ(End(), 0);
  EXPECT_THAT(Summary(), HasSubstr("\"finished\": true"));
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("</html>"));
  for (const int socket : idle) ::close(socket);
}

struct LiveUsageTest : AppTest {
  LiveUsageTest() : AppTest(TENON_QUADRUPED) {}
};

TEST_F(LiveUsageTest, ARecordingOfAnotherDiagramIsRefusedWithItsFile) {
  const std::string file = Write("recording.jsonl", R"({"tenon_live": 1, "seed": 1}
{"time": 0.1, "set": {"live_drive.velocty": [0, 0, 0]}}
{"end": 0.2, "tick": false}
)");
  ExpectRefused({{"flat --replay " + file, "--replay " + file + ": "}});
}

TEST_F(LiveUsageTest, RefusesBadUsage) {
  const std::string parameter = ": parameters.loop.world.monitor.max_til";
  ExpectRefused({{"flat --live=99999", "--live: 99999"},
                 {"flat --live --compare", "--compare"},
                 {"flat --live-address 0.0.0.0", "--live-address requires --live"},
                 {"flat --replay nowhere.jsonl", "'nowhere.jsonl'"},
                 {"stand --set 'parameters={loop.world.monitor.max_tild: [1]}'", parameter + "d: "},
                 {"stand --set 'parameters={loop.world.monitor.max_tilt: [1, 2]}'", parameter + "t: "}});
}

}  // namespace tenon::test::live_app_test
