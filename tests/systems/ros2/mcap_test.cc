// Recordings of ROS 2 messages: what is written is read back, and damage is reported.

#include <tenon/systems/ros2/mcap.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::mcap_test {

using namespace ros2;
using testing::HasSubstr;

const sensor_msgs::JointState kJoints{
    .header = {{1, 2}, "b"}, .name = {"hip", "k"}, .position = {0.5, -2}, .velocity = {}, .effort = {1e-300}};

class McapTest : public ::testing::Test {
 protected:
  ~McapTest() override { std::filesystem::remove(path); }

  /// Writes two topics in two chunks: 6000 messages in all.
  void WriteLong() const {
    const auto file = std::make_shared<McapFile>(path);
    TestRig<McapPublisher<sensor_msgs::JointState>> joints({.file = file, .topic = "/joint_states"});
    TestRig<McapPublisher<geometry_msgs::Twist>> twist({.file = file, .topic = "/cmd_vel"});
    joints.Fix(joints->u, kJoints);
    for (int i = 0; i < 3000; ++i) {
      joints.Tick();
      twist.Fix(twist->u, {.linear = {.x = static_cast<double>(i)}}).Tick();
    }
    file->Close();
  }
  /// Writes one message of one topic in one chunk.
  void WriteShort() const {
    McapFile file(path);
    const auto topic = file.AddTopic("/joint_states", internal::TypeInfoOf<sensor_msgs::JointState>());
    std::vector<char> cdr;
    internal::WriteMcapMessage(internal::TypeInfoOf<sensor_msgs::JointState>(), &kJoints, cdr);
    file.Write(topic, 0.25, cdr);
  }
  std::string WriteAndRead(const std::string& bytes, int* count) const {
    std::ofstream(path, std::ios::binary) << bytes;
    *count = 0;
    return ReadMcap(path, [&](const McapMessage& message) {
      sensor_msgs::JointState joints;
      if (message.Read(joints).empty()) ++*count;
    });
  }

  const std::filesystem::path path = test::TemporaryPath("run.mcap");
};

TEST_F(McapTest, MessagesAreReadBackInTheirOrder) {
  WriteLong();
  int joints = 0, twists = 0;
  const std::string told = ReadMcap(path, [&](const McapMessage& message) {
    EXPECT_EQ(message.encoding, "cdr");
    sensor_msgs::JointState state;
    geometry_msgs::Twist twist;
    if (message.topic == "/joint_states") {
      ASSERT_EQ(message.Read(state), "");
      EXPECT_NEAR(message.time, joints * 0.01, 1e-9);
      EXPECT_EQ(state.name, kJoints.name);
      EXPECT_EQ(state.position, kJoints.position);
      EXPECT_EQ(state.effort, kJoints.effort);
      EXPECT_EQ(state.header.frame_id, "b");
      EXPECT_EQ(state.header.stamp.nanosec, 2u);
      EXPECT_THAT(message.Read(twist), HasSubstrs("/joint_states", "geometry_msgs"));
      ++joints;
    } else {
      ASSERT_EQ(message.topic, "/cmd_vel");
      ASSERT_EQ(message.Read(twist), "");
      EXPECT_EQ(twist.linear.x, twists++);
    }
  });
  EXPECT_EQ(told, "");
  EXPECT_EQ(joints, 3000);
  EXPECT_EQ(twists, 3000);
}

TEST_F(McapTest, BytesAndDefinitionsAreThoseOfRos2) {
  WriteShort();
  const std::string file = ReadText(path);
  // CDR by hand: after the encapsulation, numbers are aligned to their size, and texts end in 0.
  using namespace std::string_literals;
  const std::string cdr = "\0\1\0\0"s + "\1\0\0\0\2\0\0\0"s + "\2\0\0\0b\0"s +
                          "\0\0"s +  // stamp, frame, padding
                          "\2\0\0\0"s + "\4\0\0\0hip\0"s + "\2\0\0\0k\0"s + "\0\0"s +      // names, padding
                          "\2\0\0\0"s + "\0\0\0\0\0\0\xE0\x3F"s + "\0\0\0\0\0\0\0\xC0"s +  // 0.5, -2
                          "\0\0\0\0"s;                                                     // no velocity
  EXPECT_NE(file.find(cdr), file.npos);
  EXPECT_THAT(file, HasSubstrs("builtin_interfaces/Time stamp\nstring frame_id\n",
                               "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] "
                               "velocity\nfloat64[] effort\n" +
                                   std::string(80, '=') + "\nMSG: std_msgs/Header\n"));
}

TEST_F(McapTest, ATruncatedFileIsReadAsFarAsItIsWhole) {
  WriteShort();
  const std::string whole = ReadText(path);
  int count = 0;
  EXPECT_EQ(WriteAndRead(whole, &count), "");
  EXPECT_EQ(count, 1);
  bool was_read = false;
  for (std::size_t size = 8; size < whole.size(); size += 13) {
    const std::string told = WriteAndRead(whole.substr(0, size), &count);
    EXPECT_GE(count, was_read ? 1 : 0) << size;
    was_read = count == 1;
    if (!was_read) {
      EXPECT_THAT(told, HasSubstrs("ends", "up to byte", "mcap"));
    }
  }
  EXPECT_TRUE(was_read);
  WriteLong();
  const std::string half = ReadText(path).substr(0, 100'000);  // within the first chunk
  EXPECT_THAT(WriteAndRead(half, &count), HasSubstr("ends within a chunk"));
  EXPECT_GT(count, 100);
}

TEST_F(McapTest, NoDamageIsTakenForAMessage) {
  WriteShort();
  const std::string whole = ReadText(path);
  const std::size_t chunk = whole.find("\x06"), begin = whole.find("hip");
  ASSERT_LT(chunk, begin);
  int count = 0;
  for (std::size_t i = 8; i < whole.size(); i += 13) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(~damaged[i]);
    try {
      WriteAndRead(damaged, &count);  // must return or throw ParameterError
    } catch (const ParameterError&) {
    }
  }
  std::string damaged = whole;
  damaged[begin] = 'x';
  EXPECT_THAT(WriteAndRead(damaged, &count), HasSubstr("checksum"));
  EXPECT_EQ(count, 0);
}

std::string Number(std::uint64_t value, int size) {
  return {reinterpret_cast<const char*>(&value), static_cast<std::size_t>(size)};
}
std::string Record(int op, const std::string& content) {
  return std::string(1, static_cast<char>(op)) + Number(content.size(), 8) + content;
}
std::string Text(const std::string& text) {
  return Number(text.size(), 4) + text;
}
const std::string kStart =
    "\x89MCAP0\r\n" + Record(1, Text("ros2") + Text("me")) +
    Record(3, Number(1, 2) + Text("geometry_msgs/msg/Twist") + Text("ros2msg") + Text("")) +
    Record(4, Number(7, 2) + Number(1, 2) + Text("/a") + Text("cdr") + Text(""));
std::string Message(const std::string& data) {
  return Record(5, Number(7, 2) + Number(0, 4) + Number(2'500'000'000, 8) + Number(0, 8) + data);
}

TEST_F(McapTest, ReadsAFileWithoutChunks) {
  std::ofstream(path, std::ios::binary)
      << kStart << Record(99, "unknown") << Message(std::string("\0\1\0\0", 4) + std::string(48, '\0'))
      << Record(15, Number(0, 4));
  int count = 0;
  EXPECT_EQ(ReadMcap(path,
                     [&](const McapMessage& message) {
                       geometry_msgs::Twist twist{.linear = {.x = 1}};
                       EXPECT_EQ(message.Read(twist), "");
                       EXPECT_EQ(twist.linear.x, 0);
                       EXPECT_EQ(message.time, 2.5);
                       ++count;
                     }),
            "");
  EXPECT_EQ(count, 1);
}

TEST_F(McapTest, HugeSizesAreRefused) {
  int count = 0;
  EXPECT_THAT(WriteAndRead(kStart + "\x05" + Number(1ULL << 62, 8), &count), HasSubstr("within a record"));
  // A list of 2^32 - 1 names in a message of a few bytes.
  sensor_msgs::JointState joints;
  const std::string data = std::string("\0\1\0\0", 4) + Number(0, 8) + Text(std::string(1, '\0')) + "   " +
                           Number(0xFFFFFFFF, 4) + Number(0, 4);
  const McapMessage message{
      .topic = "/a", .type = "sensor_msgs/msg/JointState", .encoding = "cdr", .data = data};
  EXPECT_THAT(message.Read(joints), HasSubstr("ends too early"));
  std::string swapped = data;
  swapped[1] = 0;
  const McapMessage other{.topic = "/a", .type = message.type, .encoding = "cdr", .data = swapped};
  EXPECT_THAT(other.Read(joints), HasSubstr("little endian"));
}

TEST_F(McapTest, ForeignFilesAreRefused) {
  int count = 0;
  EXPECT_TRUE(Throws<ParameterError>([&] { WriteAndRead("time,x\n", &count); }, "no MCAP file"));
  EXPECT_TRUE(Throws<ParameterError>([&] { ReadMcap("/tmp", {}); }, "/tmp"));
  const std::string lz4 =
      Record(6, Number(0, 8) + Number(0, 8) + Number(4, 8) + Number(0, 4) + Text("lz4") + Number(0, 8));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { WriteAndRead(kStart + lz4, &count); }, "lz4", "--compression none"));
  EXPECT_TRUE(Refuses<McapPublisher<geometry_msgs::Twist>>({}, "file"));
}

}  // namespace tenon::mcap_test
