// Allocations of the thread of control in the loop of --drive, with logs and recordings. A function of this
// program stands before that of Cyclone DDS that sends, and counts the allocations in it apart.

#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/temporary_path.h>

#include <dlfcn.h>
#include <fmt/core.h>

namespace tenon::driven_loop_test {

thread_local long of_cyclone = 0;                  // allocations of this thread
thread_local std::function<void()> after_message;  // is called when this thread has sent one

extern "C" dds_return_t dds_write_ts(dds_entity_t writer, const void* data, dds_time_t stamp) {
  static const auto next = reinterpret_cast<decltype(&dds_write_ts)>(dlsym(RTLD_NEXT, "dds_write_ts"));
  const AllocationGuard guard;
  const dds_return_t result = next(writer, data, stamp);
  of_cyclone += guard.count();
  if (after_message) after_message();
  return result;
}

/// Drives with a scenario until the message with the number `last`, and expects no allocation of Tenon after
/// that with the number `first`. With `ros2`, messages of ROS 2 are sent, too, else only commands.
void ExpectNoAllocation(const std::string& scenario, long first, long last, bool ros2 = false) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  const std::filesystem::path out = test::TemporaryPath("driven_loop");
  const std::string where = fmt::format("unitree:lo,{}", test::kOwnLink.domain);
  const test::SecondProcess robot([&] {
    execl(TENON_QUADRUPED, TENON_QUADRUPED, "stand", "--serve", where.c_str(), "--duration", "100", "--out",
          (out / "robot").c_str(), nullptr);
  });
  const AllocationGuard all;
  long sent = 0, ours = 0, cyclones = 0;
  after_message = [&] {
    if (++sent != first && sent != last) return;
    ours = all.count() - of_cyclone - ours;
    cyclones = of_cyclone - cyclones;
    if (sent == last) raise(SIGINT);
  };
  std::vector<std::string> words{"app",   scenario,   "--drive=" + where, "--mcap", "--duration=100",
                                 "--out", out / "run"};
  for (const char* setting : {"initial=walk", "limits.timeout_s=1", "goals=[{start_s: 0, goal: walk}]"})
    words.insert(words.end(), {"--set", std::string("deployment.") + setting});
  if (ros2) words.push_back("--ros2=" + where.substr(where.find(':') + 1));
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  EXPECT_EQ(apps::QuadrupedApp().Run(static_cast<int>(arguments.size()), arguments.data()), 130);
  after_message = nullptr;
  EXPECT_EQ(ours, 0) << scenario;
  fmt::print("{}: Cyclone DDS allocates {} times for {} messages\n", scenario, cyclones, last - first);
  std::filesystem::remove_all(out);
}

TEST(DrivenLoopTest, AllocatesNothing) {
  ExpectNoAllocation("flat", 1500, 3000, true);
}
TEST(DrivenLoopTest, AllocatesNothingOnTheWay) {  // which begins after 6 s
  for (const char* scenario : {"flat", "pushed"}) ExpectNoAllocation(scenario, 1000, 5000);
}

}  // namespace tenon::driven_loop_test
