// The options --ros2 and --mcap. The other side is another participant in the domain of this test.

#include <tenon/systems/dds/ros2.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/testing/block_test.h>

#include <fmt/core.h>

namespace tenon::apps_ros2_test {

using namespace ros2;
using test::kOwnLink, ::testing::HasSubstr;

class AppsRos2Test : public test::AppTest {
 protected:
  AppsRos2Test() : AppTest(TENON_QUADRUPED) {}
  const std::string option = fmt::format(" --ros2=lo,{}", kOwnLink.domain);
};

TEST_F(AppsRos2Test, AListenerHearsTheRunAndCommandsItsVelocity) {
  TestRig<DdsInput<nav_msgs::Odometry>> odometry(
      DdsInputParams<nav_msgs::Odometry>{.topic = "rt/odom", .link = kOwnLink});
  TestRig<DdsInput<rosgraph_msgs::Clock>> clock(
      DdsInputParams<rosgraph_msgs::Clock>{.topic = "rt/clock", .link = kOwnLink});
  TestRig<DdsPublisher<geometry_msgs::Twist>> twist({.topic = "rt/cmd_vel", .link = kOwnLink});
  twist.Fix(twist->u, {.linear = {-0.2, 0, 0}});
  std::map<long, double> heard;  // x by the time in hundredths of a second
  bool ends = false;
  std::thread listener([&] {
    while (!ends) {
      const nav_msgs::Odometry& now = odometry.Tick()[odometry->y];
      if (now.header.frame_id == "odom")
        heard[std::lround(100 * TimeOf(now.header.stamp))] = now.pose.pose.position.x;
      clock.Tick();
      twist.Tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  const std::string text =
      Run("flat --duration 3 --set walk.path_tolerance=100 --set task.arrives=false" + option);
  ends = true;
  listener.join();
  EXPECT_THAT(text, HasSubstr("publishing in ROS 2"));
  EXPECT_THAT(Summary(), HasSubstrs("\"messages_unsent\": 0.0", "\"velocities_refused\": 0.0"));
  const std::vector<double> times = test::Column(out, "time [s]"),
                            x = test::Column(out, "loop.world.plant.state.p_WB.x [m]");
  EXPECT_LT(x.back(), -0.1) << "walks backward, not forward as its scenario";
  int compared = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto sample = heard.find(std::lround(100 * times[i]));
    if (sample == heard.end() || std::abs(times[i] - 0.01 * static_cast<double>(sample->first)) > 1e-6)
      continue;
    EXPECT_NEAR(sample->second, x[i], 1e-8);
    ++compared;
  }
  EXPECT_GT(compared, 20);
  EXPECT_GT(TimeOf(clock[clock->y].clock), 2.5);
}

TEST_F(AppsRos2Test, ARecordingHasTheSameMessagesAndDoesNotChangeTheRun) {
  Run("flat --duration 0.5");
  const std::string without = Signals();
  EXPECT_FALSE(std::filesystem::exists(out / "run.mcap"));
  Run("flat --duration 0.5 --mcap");
  EXPECT_EQ(Signals(), without);
  std::map<std::string, int> count;
  std::vector<double> x;
  std::string urdf;
  EXPECT_EQ(ReadMcap(out / "run.mcap",
                     [&](const McapMessage& message) {
                       ++count[std::string(message.topic)];
                       nav_msgs::Odometry odometry;
                       std_msgs::String text;
                       if (message.topic == "/odom") {
                         EXPECT_EQ(message.Read(odometry), "");
                         x.push_back(odometry.pose.pose.position.z);
                       } else if (message.topic == "/robot_description") {
                         EXPECT_EQ(message.Read(text), "");
                         urdf = text.data;
                       }
                     }),
            "");
  for (const char* topic : {"/odom", "/tf", "/disturbance", "/clock"}) EXPECT_EQ(count[topic], 51) << topic;
  for (const char* topic : {"/joint_states", "/imu", "/foot_force/rear_left"})
    EXPECT_EQ(count[topic], 501) << topic << " at the rate of its sensor";
  EXPECT_EQ(count["/tf_static"], 1);
  EXPECT_EQ(count["/robot_description"], 1);
  EXPECT_THAT(urdf, HasSubstr("<robot"));
  const std::vector<double> z = test::Column(out, "loop.world.plant.state.p_WB.z [m]");  // at 200 Hz
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], z[2 * i], 1e-8);
  Run("flat --duration 0.1");
  EXPECT_FALSE(std::filesystem::exists(out / "run.mcap")) << "of an earlier run";
}

TEST_F(AppsRos2Test, AReportOfARecordingHasItsNumbers) {
  Run("flat --duration 0.5 --mcap");
  const std::vector<double> z = test::Column(out, "loop.world.plant.state.p_WB.z [m]");
  const std::string mcap = (out / "run.mcap").string(), to = " --out " + (out / "log").string();
  const auto report = [&] { return test::RunCommand(TENON_REPORT + (" " + mcap) + to); };
  const test::Result whole = report();
  EXPECT_EQ(whole.exit_code, 0) << whole.text;
  EXPECT_THAT(whole.text, HasSubstrs("report.html", "'/tf' is not shown"));
  const std::vector<double> read = test::Column(out / "log", "odom.message.pose.pose.position.z");
  ASSERT_EQ(read.size(), 51u);
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_NEAR(read[i], z[2 * i], 1e-8);
  EXPECT_EQ(test::Column(out / "log", "joint_states.message.position.front_left_knee").size(), 51u);
  std::filesystem::resize_file(mcap, 100'000);
  const test::Result cut = report();
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_THAT(cut.text, HasSubstrs("of 100000", "ends within a chunk"));
  std::filesystem::resize_file(mcap, 4);
  EXPECT_EQ(report().exit_code, 2);
}

TEST_F(AppsRos2Test, RefusesAnInvalidPlace) {
  EXPECT_THAT(Run("flat --duration 0.1 --ros2=lo,x", 2), HasSubstrs("--ros2", "DOMAIN"));
  EXPECT_THAT(Run("flat --duration 0.1 --ros2=no_such", 2), HasSubstr("'no_such'"));
  const test::Result foreign = test::RunCommand(std::string("ROS_DOMAIN_ID=999 ") + TENON_QUADRUPED +
                                                " flat --duration 0.1 --ros2" + Out());
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_THAT(foreign.text, HasSubstr("ROS_DOMAIN_ID"));
}

}  // namespace tenon::apps_ros2_test
