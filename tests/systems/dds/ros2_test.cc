// Messages of ROS 2 by DDS. The other side is a second participant with the C structs of idlc.

#include <tenon/systems/dds/ros2.h>
#include <tenon/systems/ros2/internal/cdr.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fmt/format.h>
#include <ros2.h>

#include <numeric>
#include <thread>

namespace tenon::ros2_test {

using namespace ros2;
using test::kOwnLink, testing::ElementsAre, testing::HasSubstr;

std::string Topic(const std::string& name) {
  return "rt/" + name + "_" + std::to_string(getpid());
}

/// Reads the last message of a topic into a struct of idlc.
template <class C>
class Listener {
 public:
  Listener(const std::string& topic, const dds_topic_descriptor_t& descriptor, bool reliable = true,
           bool transient_local = false)
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(kOwnLink.domain), nullptr, nullptr)) {
    const dds_entity_t made = dds_create_topic(participant_, &descriptor, topic.c_str(), nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    if (transient_local) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    reader_ = dds_create_reader(participant_, made, qos, nullptr);
    dds_delete_qos(qos);
    EXPECT_GT(reader_, 0);
  }
  ~Listener() { dds_delete(participant_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// Null if there is none. Valid until the next call.
  const C* Take() {
    if (samples_[0] != nullptr) dds_return_loan(reader_, samples_, 1);
    samples_[0] = nullptr;
    dds_sample_info_t info;
    return dds_take(reader_, samples_, &info, 1, 1) > 0 ? static_cast<const C*>(samples_[0]) : nullptr;
  }

 private:
  dds_entity_t participant_, reader_ = 0;
  void* samples_[1] = {nullptr};
};

/// Sets every number to another value, and every text.
template <class M>
M Distinct(M message) {
  std::vector<double> numbers(internal::CountScalars(internal::TypeInfoOf<M>(), &message));
  std::iota(numbers.begin(), numbers.end(), 1);
  internal::FromDoubles(internal::TypeInfoOf<M>(), &message, numbers.data());
  struct Texts final : internal::ValueVisitor {
    void Numbers(void*, internal::ScalarKind, std::size_t, std::size_t) override {}
    void Text(std::string& text) override { text += "t" + std::to_string(count++); }
    int count = 0;
  } texts;
  internal::Walk(internal::TypeInfoOf<M>(), &message, texts);
  return message;
}

template <class M>
std::vector<char> Contents(const M& message) {
  std::vector<char> bytes;
  internal::WriteCdr(internal::TypeInfoOf<M>(), &message, bytes);
  return bytes;
}

sensor_msgs::JointState ThreeJoints() {
  return Distinct(sensor_msgs::JointState{.name = {"a", "", "a long name of a joint"},
                                          .position = {0, 0, 0},
                                          .velocity = {0, 0, 0},
                                          .effort = {}});
}
tf2_msgs::TFMessage TwoTransforms() {
  return Distinct(tf2_msgs::TFMessage{.transforms = {{}, {}}});
}
sensor_msgs::Joy Gamepad() {
  return Distinct(sensor_msgs::Joy{.axes = {0, 0}, .buttons = {0, 0, 0}});
}

/// Sends a message with a DdsPublisher, and reads it with a struct of idlc and with a DdsInput of a shape.
template <class M, class C>
void ExpectArrives(const M& message, const dds_topic_descriptor_t& descriptor, const M& shape,
                   const std::function<void(const C&)>& check) {
  SCOPED_TRACE(descriptor.m_typename);
  const std::string topic = Topic("both_ways");
  TestRig<DdsInput<M>> input(DdsInputParams<M>{.topic = topic, .link = kOwnLink, .initial = shape});
  TestRig<DdsPublisher<M>> publisher({.topic = topic, .link = kOwnLink});
  Listener<C> reliable(topic, descriptor), sensor(topic, descriptor, false);
  publisher.Fix(publisher->u, message).Tick();
  for (Listener<C>* listener : {&reliable, &sensor}) {
    const C* heard = listener->Take();
    ASSERT_NE(heard, nullptr);
    check(*heard);
  }
  EXPECT_EQ(Contents(input.Tick()[input->y]), Contents(message));
  EXPECT_EQ(input[input->refused].reason, "");
  // The input also reads the message from a sender that has the type of idlc.
  Listener<C> last(topic, descriptor);
  const test::DdsPeer peer(topic, descriptor);
  publisher.Fix(publisher->u, message).Tick();
  const C* again = last.Take();
  ASSERT_NE(again, nullptr);
  TestRig<DdsInput<M>> other(DdsInputParams<M>{.topic = topic, .link = kOwnLink, .initial = shape});
  peer.Send(again, 1);
  EXPECT_EQ(Contents(other.Tick()[other->y]), Contents(message));
  EXPECT_EQ(publisher[publisher->unsent], 0u);
}

TEST(Ros2Test, EachTypeArrivesBothWays) {
  ExpectArrives<sensor_msgs::JointState, sensor_msgs_msg_dds__JointState_>(
      ThreeJoints(), sensor_msgs_msg_dds__JointState__desc, ThreeJoints(), [](const auto& c) {
        EXPECT_EQ(c.header.stamp.sec, 1);
        EXPECT_EQ(c.header.stamp.nanosec, 2u);
        EXPECT_STREQ(c.header.frame_id, "t0");
        ASSERT_EQ(c.name._length, 3u);
        EXPECT_STREQ(c.name._buffer[0], "at1");
        EXPECT_STREQ(c.name._buffer[1], "t2");
        EXPECT_STREQ(c.name._buffer[2], "a long name of a jointt3");
        ASSERT_EQ(c.velocity._length, 3u);
        EXPECT_EQ(c.position._buffer[2], 5);
        EXPECT_EQ(c.velocity._buffer[0], 6);
        EXPECT_EQ(c.effort._length, 0u);
      });
  ExpectArrives<sensor_msgs::Imu, sensor_msgs_msg_dds__Imu_>(
      Distinct(sensor_msgs::Imu{}), sensor_msgs_msg_dds__Imu__desc, {}, [](const auto& c) {
        EXPECT_EQ(c.orientation.x, 3);
        EXPECT_EQ(c.orientation.w, 6);
        EXPECT_EQ(c.orientation_covariance[0], 7);
        EXPECT_EQ(c.angular_velocity.x, 16);
        EXPECT_EQ(c.linear_acceleration.z, 30);
        EXPECT_EQ(c.linear_acceleration_covariance[8], 39);
      });
  ExpectArrives<nav_msgs::Odometry, nav_msgs_msg_dds__Odometry_>(
      Distinct(nav_msgs::Odometry{}), nav_msgs_msg_dds__Odometry__desc, {}, [](const auto& c) {
        EXPECT_STREQ(c.header.frame_id, "t0");
        EXPECT_STREQ(c.child_frame_id, "t1");
        EXPECT_EQ(c.pose.pose.position.x, 3);
        EXPECT_EQ(c.pose.covariance[35], 45);
        EXPECT_EQ(c.twist.twist.angular.z, 51);
      });
  ExpectArrives<geometry_msgs::WrenchStamped, geometry_msgs_msg_dds__WrenchStamped_>(
      Distinct(geometry_msgs::WrenchStamped{}), geometry_msgs_msg_dds__WrenchStamped__desc, {},
      [](const auto& c) {
        EXPECT_EQ(c.wrench.force.x, 3);
        EXPECT_EQ(c.wrench.torque.z, 8);
      });
  ExpectArrives<tf2_msgs::TFMessage, tf2_msgs_msg_dds__TFMessage_>(
      TwoTransforms(), tf2_msgs_msg_dds__TFMessage__desc, TwoTransforms(), [](const auto& c) {
        ASSERT_EQ(c.transforms._length, 2u);
        EXPECT_STREQ(c.transforms._buffer[0].child_frame_id, "t1");
        EXPECT_STREQ(c.transforms._buffer[1].header.frame_id, "t2");
        EXPECT_EQ(c.transforms._buffer[1].transform.rotation.w, 18);
      });
  ExpectArrives<rosgraph_msgs::Clock, rosgraph_msgs_msg_dds__Clock_>(
      Distinct(rosgraph_msgs::Clock{}), rosgraph_msgs_msg_dds__Clock__desc, {},
      [](const auto& c) { EXPECT_EQ(c.clock.nanosec, 2u); });
  ExpectArrives<std_msgs::String, std_msgs_msg_dds__String_>(
      {.data = std::string(100000, 'x')}, std_msgs_msg_dds__String__desc, {},
      [](const auto& c) { EXPECT_EQ(std::strlen(c.data), 100000u); });
  ExpectArrives<geometry_msgs::Twist, geometry_msgs_msg_dds__Twist_>(
      Distinct(geometry_msgs::Twist{}), geometry_msgs_msg_dds__Twist__desc, {},
      [](const auto& c) { EXPECT_EQ(c.angular.z, 6); });
  ExpectArrives<sensor_msgs::Joy, sensor_msgs_msg_dds__Joy_>(Gamepad(), sensor_msgs_msg_dds__Joy__desc,
                                                             Gamepad(), [](const auto& c) {
                                                               ASSERT_EQ(c.axes._length, 2u);
                                                               ASSERT_EQ(c.buttons._length, 3u);
                                                               EXPECT_EQ(c.axes._buffer[1], 4);
                                                               EXPECT_EQ(c.buttons._buffer[2], 7);
                                                             });
}

TEST(Ros2Test, TypesHaveTheNamesOfRos2) {
  EXPECT_EQ(NameOf(internal::TypeInfoOf<sensor_msgs::JointState>()), "sensor_msgs/msg/JointState");
  EXPECT_EQ(DdsNameOf(internal::TypeInfoOf<tf2_msgs::TFMessage>()), "tf2_msgs::msg::dds_::TFMessage_");
}

TEST(Ros2Test, LateReadersReceiveTheDescriptionOfTheRobot) {
  const std::string topic = Topic("robot_description");
  TestRig<DdsPublisher<std_msgs::String>> publisher(
      {.topic = topic, .link = kOwnLink, .depth = 1, .transient_local = true});
  publisher.Fix(publisher->u, {"<robot/>"}).Tick();
  Listener<std_msgs_msg_dds__String_> late(topic, std_msgs_msg_dds__String__desc, true, true);
  const std_msgs_msg_dds__String_* heard = nullptr;
  EXPECT_TRUE(test::Within10s([&] { return (heard = late.Take()) != nullptr; }));
  ASSERT_NE(heard, nullptr);
  EXPECT_STREQ(heard->data, "<robot/>");
}

TEST(Ros2Test, RefusesAndNamesWhatDoesNotFit) {
  const std::string topic = Topic("joints_in");
  const sensor_msgs::JointState initial = ThreeJoints();
  TestRig<DdsInput<sensor_msgs::JointState>> rig(
      DdsInputParams<sensor_msgs::JointState>{.topic = topic, .link = kOwnLink, .initial = initial});
  TestRig<DdsPublisher<sensor_msgs::JointState>> sender({.topic = topic, .link = kOwnLink});
  std::uint64_t count = 0;
  const auto expect_refused = [&](const sensor_msgs::JointState& message, const char* reason) {
    sender.Fix(sender->u, message).Tick();
    EXPECT_EQ(Contents(rig.Tick()[rig->y]), Contents(initial));
    EXPECT_EQ(rig[rig->refused].count, ++count);
    EXPECT_THAT(rig[rig->refused].reason, HasSubstrs(topic, reason));
  };
  sensor_msgs::JointState nan = initial, longer = initial, shorter = initial, unnamed = initial;
  nan.velocity[1] = test::kNan;
  longer.position.push_back(1);
  shorter.velocity.clear();
  unnamed.name.resize(2);
  expect_refused(nan, "'velocity.1' = nan is not finite");
  expect_refused(longer, "'position' has 4 elements, but the signal has 3");
  expect_refused(shorter, "'velocity' has 0 elements");
  expect_refused(unnamed, "'name' has 2 elements");
}

TEST(Ros2Test, ReadsInLockStep) {
  const std::string topic = Topic("lock_step");
  TestRig<DdsPublisher<sensor_msgs::JointState>> sender(
      {.topic = topic, .link = kOwnLink, .rate = Hz(10), .lock_step = true});
  TestRig<DdsInput<sensor_msgs::JointState>> rig(DdsInputParams<sensor_msgs::JointState>{
      .topic = topic, .link = kOwnLink, .initial = ThreeJoints(), .rate = Hz(10), .lock_step = true});
  sensor_msgs::JointState message = ThreeJoints();
  for (int i = 0; i < 20; ++i) {
    message.position[0] = i;
    sender.Fix(sender->u, message).Tick();
    EXPECT_EQ(rig.Tick()[rig->y].position[0], i);
  }
}

namespace my_msgs {
struct Other {
  using IsMessage = void;
  double x = 0;
  static FieldList Fields() { return {{"x", &Other::x}}; }
};
}  // namespace my_msgs

TEST(Ros2Test, ATypeWithoutIdlIsRefused) {
  EXPECT_TRUE(Throws<ParameterError>([] { DdsMessageOf<my_msgs::Other>::Get(); },
                                     "my_msgs::msg::dds_::Other_", "MakeRos2Message"));
}

TEST(Ros2VelocityTest, TakesTwistAndGamepadWithinBoundsUntilTheyAreOld) {
  const Ros2VelocityParams params{
      .twist = Topic("cmd_vel"), .joy = Topic("joy"), .link = kOwnLink, .rate = Hz(10), .record = true};
  TestRig<Ros2Velocity> rig(params);
  TestRig<DdsPublisher<geometry_msgs::Twist>> twist({.topic = params.twist, .link = kOwnLink});
  TestRig<DdsPublisher<sensor_msgs::Joy>> joy({.topic = params.joy, .link = kOwnLink});
  const auto expect = [&](bool active, const Vec<3>& velocity) {
    const VelocityCommand now = rig.Tick()[rig->y];
    EXPECT_EQ(now.active, active);
    EXPECT_LT((now.velocity - velocity).norm(), 1e-7) << now.velocity.transpose();
  };
  expect(false, {0, 0, 0});
  twist.Fix(twist->u, {.linear = {0.2, -5, 3}, .angular = {7, 7, 0.1}}).Tick();
  expect(true, {0.2, -0.15, 0.1});
  sensor_msgs::Joy stick{.axes = {0.5F, -1, 9, -0.5F}, .buttons = {0, 0, 0, 0, 1}};
  joy.Fix(joy->u, stick).Tick();
  expect(true, {-0.3, 0.075, -0.25});
  stick.buttons[4] = 0;
  joy.Fix(joy->u, stick).Tick();
  expect(true, {0.2, -0.15, 0.1});
  for (int i = 0; i < 3; ++i) expect(true, {0.2, -0.15, 0.1});
  expect(true, {0, 0, 0});
  EXPECT_EQ(rig[rig->refused].count, 0u);

  stick.axes.resize(2);
  joy.Fix(joy->u, stick).Tick();
  twist.Fix(twist->u, {.linear = {test::kNan, 0, 0}}).Tick();
  expect(true, {0, 0, 0});
  EXPECT_EQ(rig[rig->refused].count, 2u);
  EXPECT_THAT(rig[rig->refused].reason, HasSubstr("2 axes and 5 buttons"));

  Ros2VelocityParams again = params;
  again.replay = rig[rig->taken].recording;
  TestRig<Ros2Velocity> replay(again);
  std::vector<double> forward;
  for (int i = 0; i < 6; ++i) forward.push_back(replay.Tick()[replay->y].velocity[0]);
  EXPECT_THAT(forward, ElementsAre(0, 0.2, testing::DoubleEq(-0.3), 0.2, 0.2, 0.2));
}

TEST(Ros2LinkTest, HasTheDomainOfTheEnvironment) {
  setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(Ros2Link("lo").domain, 42);
  setenv("ROS_DOMAIN_ID", "300", 1);
  EXPECT_TRUE(Throws<ParameterError>([] { Ros2Link(); }, "ROS_DOMAIN_ID", "300"));
  unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(Ros2Link().domain, 0);
}

#ifdef TENON_FAST_DDS_PEER

/// fast_dds_peer.cc, which sends back what it receives.
class FastDdsTest : public ::testing::Test {
 protected:
  FastDdsTest() {
    const std::string command =
        fmt::format("{} {} {} > {}", TENON_FAST_DDS_PEER, kOwnLink.domain, prefix, printed.string());
    pipe_ = popen(command.c_str(), "w");
  }
  ~FastDdsTest() override {
    End();
    std::filesystem::remove(printed);
  }
  void End() {
    if (pipe_ != nullptr) pclose(pipe_);
    pipe_ = nullptr;
  }
  /// Sends a message until it comes back.
  template <class M>
  void ExpectComesBack(const std::string& name, const M& message, const M& shape) {
    const std::string topic = prefix + name;
    TestRig<DdsPublisher<M>> publisher({.topic = topic, .link = kOwnLink});
    TestRig<DdsInput<M>> input(
        DdsInputParams<M>{.topic = topic + "_back", .link = kOwnLink, .initial = shape});
    publisher.Fix(publisher->u, message);
    EXPECT_TRUE(test::Within10s([&] {
      publisher.Tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      return input.Tick()[input->taken].number > 0;
    })) << name;
    EXPECT_EQ(Contents(input[input->y]), Contents(message)) << name;
    EXPECT_EQ(input[input->refused].reason, "");
  }

  const std::string prefix = Topic("fast") + "_";
  const std::filesystem::path printed = test::TemporaryPath("fast_dds.txt");

 private:
  std::FILE* pipe_ = nullptr;
};

TEST_F(FastDdsTest, EachTypeComesBack) {
  ExpectComesBack("JointState", ThreeJoints(), ThreeJoints());
  ExpectComesBack("Imu", Distinct(sensor_msgs::Imu{}), {});
  ExpectComesBack("Odometry", Distinct(nav_msgs::Odometry{}), {});
  ExpectComesBack("WrenchStamped", Distinct(geometry_msgs::WrenchStamped{}), {});
  ExpectComesBack("TFMessage", TwoTransforms(), TwoTransforms());
  ExpectComesBack("Clock", Distinct(rosgraph_msgs::Clock{}), {});
  ExpectComesBack("String", std_msgs::String{std::string(10000, 'x')}, {});
  ExpectComesBack("Twist", Distinct(geometry_msgs::Twist{}), {});
  ExpectComesBack("Joy", Gamepad(), Gamepad());
}

TEST_F(FastDdsTest, LosesNoneOfTenThousandMessagesAfterDiscovery) {
  using Clock = std::chrono::steady_clock;
  const std::string topic = prefix + "JointState";
  // Both machines may be busy for a second; with the ten messages of ROS 2, none may be for 10 ms.
  TestRig<DdsPublisher<sensor_msgs::JointState>> publisher({.topic = topic, .link = kOwnLink, .depth = 1000});
  Listener<sensor_msgs_msg_dds__JointState_> back(topic + "_back", sensor_msgs_msg_dds__JointState__desc);
  sensor_msgs::JointState message = ThreeJoints();
  std::uint32_t sent = 0, first = 0, last = 0, count = 0, due = UINT32_MAX;
  const auto receive = [&] {
    while (const auto* heard = back.Take()) {
      last = heard->header.stamp.nanosec;
      if (count++ == 0) first = last;
    }
  };
  const auto end = Clock::now() + std::chrono::seconds(60);
  auto next = Clock::now();
  while (sent < due && Clock::now() < end) {
    message.header.stamp.nanosec = ++sent;
    publisher.Fix(publisher->u, message).Tick();
    receive();
    if (count > 0 && due == UINT32_MAX) due = sent + 10000;
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
  }
  EXPECT_EQ(sent, due);
  EXPECT_TRUE(test::Within10s([&] {
    receive();
    return last == sent;
  }));
  EXPECT_EQ(count, last - first + 1);
  EXPECT_GE(count, 10000u);
  EXPECT_EQ(publisher[publisher->unsent], 0u);
  End();
  std::ifstream lines(printed);
  std::string name;
  long received = 0, lost = -1;
  while (lines >> name >> received >> lost && name != topic) {
  }
  EXPECT_EQ(name, topic);
  EXPECT_GE(received, 10000);
  EXPECT_EQ(lost, 0);
}

#endif

}  // namespace tenon::ros2_test
