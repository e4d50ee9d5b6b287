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
#include <thread>

namespace tenon::drive_test {

using test::kOwnLink;

class DriveTest : public test::AppTest {
 protected:
  DriveTest() : AppTest(TENON_QUADRUPED) {}
};

enum class Sent { kOther, kDamped, kPassive };
Sent KindOf(const UnitreeCommand& command) {
  if (!command.kp.isZero(0) || !command.torque.isZero(0)) return Sent::kOther;
  return command.kd.isZero(0) ? Sent::kPassive : Sent::kDamped;
}

// The robot counts the commands that it hears before and after the signal.
TEST_F(DriveTest, CtrlCDampsTheJointsAndThenReleasesThem) {
  std::filesystem::create_directories(out);
  TestRig<DdsPublisher<UnitreeState>> states({.topic = "rt/lowstate", .link = kOwnLink});
  TestRig<DdsInput<UnitreeCommand>> commands({.topic = "rt/lowcmd", .link = kOwnLink});
  TestRig<MotionSwitcher> switcher({.link = kOwnLink});
  std::atomic<bool> ends = false;
  std::vector<Sent> heard;
  std::thread robot([&] {
    const QuadrupedDescription go2 = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
    UnitreeState state;
    state.joints.q = go2.stance;
    state.inertial.specific_force_B[2] = kGravity;
    std::uint64_t last = 0;
    bool signalled = false;
    while (!ends) {
      state.time += 0.001;
      states.Fix(states->u, state).Tick();
      switcher.Tick();
      const Sent kind = KindOf(commands.Tick()[commands->y]);
      if (std::exchange(last, commands[commands->taken].number) != last) heard.push_back(kind);
      if (!signalled && heard.size() > 20 && kind == Sent::kOther) {
        kill(std::stoi(ReadText(out / "process")), SIGINT);
        signalled = true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const test::Result result =
      test::RunCommand(fmt::format("bash -c '{} flat --drive unitree:lo,{} --set deployment.initial=stand "
                                   "--set deployment.damp_time_s=0.1 "
                                   "--set \"deployment.goals=[{{start_s: 0, goal: stand}}]\" "
                                   "--set deployment.limits.timeout_s=1 --mcap {} & echo $! > {}; "
                                   "wait'",
                                   app, kOwnLink.domain, Out(), (out / "process").string()));
  ends = true;
  robot.join();
  EXPECT_THAT(result.text, ::testing::HasSubstr("interrupted"));
  EXPECT_FALSE(switcher[switcher->active]) << "the built-in mode was released";
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

}  // namespace tenon::drive_test
