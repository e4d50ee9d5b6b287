// The option --drive against a robot in this process. It does not move: its states are those of standing.

#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/testing/test_rig.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <atomic>

namespace tenon::drive_test {

using test::kOwnLink;

enum class Sent { kOther, kDamped, kPassive };
Sent KindOf(const UnitreeCommand& command) {
  if (!command.kp.isZero(0) || !command.torque.isZero(0)) return Sent::kOther;
  return command.kd.isZero(0) ? Sent::kPassive : Sent::kDamped;
}

/// A robot that stands and sends its state until `ends`, or until `hear` returns false for a command.
template <class Hear>
std::thread Robot(std::atomic<bool>& ends, Hear hear) {
  return std::thread([&ends, hear] {
    TestRig<DdsPublisher<UnitreeState>> states({.topic = "rt/lowstate", .link = kOwnLink});
    TestRig<DdsInput<UnitreeCommand>> commands({.topic = "rt/lowcmd", .link = kOwnLink});
    TestRig<MotionSwitcher> switcher({.link = kOwnLink});
    UnitreeState state{.joints = {.q = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml").stance}};
    state.inertial.specific_force_B[2] = kGravity;
    std::uint64_t last = 0;
    for (bool on = true; on && !ends;) {
      state.time += 0.001;
      states.Fix(states->u, state).Tick();
      switcher.Tick();
      const Sent kind = KindOf(commands.Tick()[commands->y]);
      if (std::exchange(last, commands[commands->taken].number) != last) on = hear(kind);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_FALSE(switcher[switcher->active]) << "the built-in mode was released";
  });
}

class DriveTest : public test::AppTest {
 protected:
  DriveTest() : AppTest(TENON_QUADRUPED) { std::filesystem::create_directories(out); }
  /// Keeps the robot standing; the file `process` has the number of the process.
  test::Result Drive(const std::string& options) {
    return test::RunCommand(
        fmt::format("bash -c '{} flat --drive unitree:lo,{} --set deployment.initial=stand "
                    "--set deployment.damp_time_s=0.1 "
                    "--set \"deployment.goals=[{{start_s: 0, goal: stand}}]\" {}{} & echo $! > {}; "
                    "wait $!'",
                    app, kOwnLink.domain, options, Out(), (out / "process").string()));
  }
};

// The robot counts the commands that it hears before and after the signal.
TEST_F(DriveTest, CtrlCDampsTheJointsAndThenReleasesThem) {
  std::atomic<bool> ends = false;
  std::vector<Sent> heard;
  bool signalled = false;
  std::thread robot = Robot(ends, [&](Sent kind) {
    heard.push_back(kind);
    if (!signalled && heard.size() > 20 && kind == Sent::kOther) {
      kill(std::stoi(ReadText(out / "process")), SIGINT);
      signalled = true;
    }
    return true;
  });
  const test::Result result = Drive("--set deployment.limits.timeout_s=1 --mcap");
  ends = true;
  robot.join();
  EXPECT_THAT(result.text, ::testing::HasSubstr("interrupted"));
  const nlohmann::json summary = nlohmann::json::parse(Summary());
  EXPECT_EQ(summary.at("mode"), "stand");
  EXPECT_GT(summary.at("states"), 10);
  for (const char* times : {"tick_late_us", "tick_compute_us", "round_trip_us"})
    EXPECT_GT(summary.at(times).at("p50"), 0) << times;
  std::map<std::string, int> recorded;
  EXPECT_EQ(ReadMcap(out / "run.mcap", [&](const auto& message) { ++recorded[std::string(message.topic)]; }),
            "");
  EXPECT_EQ(recorded.at("/joint_commands"), recorded.at("/joint_states"));
  ASSERT_FALSE(heard.empty());
  EXPECT_EQ(heard.back(), Sent::kPassive);
  const auto damped = std::find(heard.begin(), heard.end(), Sent::kDamped);
  EXPECT_GT(std::count(damped, heard.end(), Sent::kDamped), 5);
  EXPECT_EQ(std::count(damped, heard.end(), Sent::kOther), 0) << "behind the first that damps";
}

TEST_F(DriveTest, ARunThatLosesItsRobotEndsAndIsNotFinished) {
  std::atomic<bool> ends = false;
  int heard = 0;
  std::thread robot = Robot(ends, [&](Sent) { return ++heard < 20; });
  const test::Result result = Drive("--set deployment.limits.timeout_s=0.5");
  ends = true;
  robot.join();
  EXPECT_EQ(result.exit_code, 3) << result.text;
  const nlohmann::json summary = nlohmann::json::parse(Summary());
  EXPECT_EQ(summary.at("finished"), false);
  EXPECT_EQ(summary.at("fault"), "lost");
  EXPECT_THAT(std::string(summary.at("end_reason")), ::testing::HasSubstr("lost"));
  EXPECT_LT(summary.at("simulated_s"), 2);
}

}  // namespace tenon::drive_test
