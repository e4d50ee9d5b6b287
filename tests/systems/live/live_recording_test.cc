#include <tenon/systems/live/internal/live_file.h>
#include <tenon/tests/systems/live/live_diagram.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::live_recording_test {

class LiveRecordingTest : public testing::Test {
 protected:
  ~LiveRecordingTest() override { std::filesystem::remove(file_); }
  LiveRecording Read(const std::string& text) {
    std::ofstream(file_) << text;
    return LiveRecording::Read(file_);
  }
  const std::filesystem::path file_ = test::TemporaryPath("recording.jsonl");
};

TEST_F(LiveRecordingTest, ReadsWhatWasWritten) {
  internal::LiveFile file(file_, 18446744073709551615U);
  file.Add({0.1, {{"a.b", {0.1 + 0.2, -1e-300}}, {"a.c", {3}}}});
  file.Add({0.1, {{"a.b", {5}}}});
  file.Add({0.7, {{"a.b", {6}}}});
  file.DropFrom(0.5);
  file.End(0.9, true);
  const LiveRecording read = LiveRecording::Read(file_);
  EXPECT_EQ(read.seed, 18446744073709551615U);
  ASSERT_EQ(read.entries.size(), 2U);
  EXPECT_EQ(read.entries[0].time, 0.1);
  EXPECT_EQ(read.entries[0].sets[0].values, (std::vector<double>{0.1 + 0.2, -1e-300}));
  EXPECT_EQ(read.entries[0].sets[1].path, "a.c");
  EXPECT_EQ(read.end, 0.9);
  EXPECT_TRUE(read.end_tick);
}

TEST_F(LiveRecordingTest, WrongLinesAreNamed) {
  const std::string head = "{\"tenon_live\": 1, \"seed\": 1}\n";
  EXPECT_TRUE(Throws<ParameterError>(
      [&] { Read(head + "{\"time\": 1, \"set\": {\"a\": [1]}}\n{\"time\": 0, \"set\": {}}\nx\n"); },
      "recording.jsonl:3:", "live.jsonl"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Read("{\"tenon_live\": 9, \"seed\": 1}\n"); }, "recording.jsonl:1:"));
  for (const char* seed : {"-1", "1.5", "1e300", "1.0", "\"1\"", "null"})
    EXPECT_TRUE(Throws<ParameterError>(
        [&] { Read("{\"tenon_live\": 1, \"seed\": " + std::string(seed) + "}\n"); }, "recording.jsonl:1:"))
        << seed;
  EXPECT_TRUE(Throws<ParameterError>([&] { Read(head + "{\"end\": 1e308, \"tick\": true}\n"); }, ":2:"));
  EXPECT_EQ(Read("\xEF\xBB\xBF" + head).seed, 1U) << "a byte-order mark";
  EXPECT_TRUE(Throws<ParameterError>([&] { Read(""); }, ":1: the recording is empty"));
  EXPECT_TRUE(Throws<ParameterError>([&] { LiveRecording::Read("nowhere.jsonl"); }, "'nowhere.jsonl'"));
  // A killed run may leave an incomplete line.
  EXPECT_EQ(Read(head + "{\"time\": 1, \"set\": {\"a\": [1]}}\n{\"time\": 2, \"se").entries.size(), 1U);
}

TEST_F(LiveRecordingTest, AnotherDiagramIsRefused) {
  test::LiveCart cart;
  Simulator simulator(*cart.diagram);
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Replay(simulator, {0, {{0.5, {{"engine.farce", {1}}}}}, 1, true});
      },
      "t = 0.5 s", "engine.force"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Replay(simulator, {0, {{0.5, {{"engine.gear", {0.5}}}}}, 1, true});
      },
      "'engine.gear'", "t = 0.5 s"));
  Simulator other(*cart.diagram);
  EXPECT_TRUE(Throws<ParameterError>([&] { Replay(other, {0, {}, {}, false}); }, "recording", "end"));
}

}  // namespace tenon::live_recording_test
