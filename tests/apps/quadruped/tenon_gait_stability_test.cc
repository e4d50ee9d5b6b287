// Eigenvalues of the return map of a gait.

#include <tenon/tests/apps/run_app.h>

namespace tenon::tenon_gait_stability_test {

using test::Result, test::RunCommand;

Result RunApp(const std::string& arguments) {
  return RunCommand(TENON_GAIT_STABILITY " " + arguments);
}

/// The numbers of a line; all other text is skipped.
std::vector<double> NumbersOf(const std::string& line) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t length = 0;
    try {
      numbers.push_back(std::stod(line.substr(i), &length));
    } catch (const std::invalid_argument&) {
      length = 1;
    }
    i += length;
  }
  return numbers;
}

// All modes but position and heading are stable, and the map predicts how a small push decays.
TEST(TenonGaitStabilityTest, TheTrotIsStableAndItsMapPredictsThePush) {
  const Result result = RunApp("flat --settle 6 --strides 4");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  std::istringstream lines(result.text);
  int neutral = 0, strides = 0;
  double largest = 0, last = 1;
  int slow = 0;  // modes of the slope filter and its covariance, which change nothing on level ground
  bool pushed = false;
  for (std::string line; std::getline(lines, line);) {
    const std::vector<double> numbers = NumbersOf(line);
    pushed |= line.find("a push of") == 0;
    if (!pushed && line.find("  |") == 0) {
      ASSERT_EQ(numbers.size(), 3u) << line;
      if (line.find("neutral") != std::string::npos) {
        ++neutral;
      } else if (numbers[0] > 0.5) {
        ++slow;
        EXPECT_LT(numbers[0], 0.95) << line;
      } else {
        largest = std::max(largest, numbers[0]);
      }
    } else if (pushed && numbers.size() == 4 && line.back() == '%') {
      ++strides;
      EXPECT_LT(numbers[3], 10) << line;
      EXPECT_LT(numbers[1], 0.3 * last) << line;
      last = numbers[1];
    }
  }
  EXPECT_EQ(neutral, 3) << result.text;
  EXPECT_LE(slow, 5);
  EXPECT_GT(largest, 0);
  EXPECT_LT(largest, 0.3) << "with the drives at their speed limit in each swing; 0.2 without";
  EXPECT_EQ(strides, 4);
}

// The last segment begins at 3 s.
TEST(TenonGaitStabilityTest, AnalysesTheLastSegment) {
  const Result result = RunApp(
      "flat --settle 2 --strides 1 --set \"walk.path.segments=[{gait: trot, duration_s: 3}, "
      "{gait: pace, duration_s: 1}]\"");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string head = result.text.substr(0, result.text.find('\n'));
  EXPECT_NE(head.find("pace at 0 m/s"), std::string::npos) << head;
  ASSERT_GE(NumbersOf(head).size(), 3u) << head;
  EXPECT_GT(NumbersOf(head)[2], 3 + 2 * NumbersOf(head)[1]) << head;
}

TEST(TenonGaitStabilityTest, RefusesBadUsage) {
  const std::string segments = ": walk.path.segments: ";
  for (const auto& [arguments, place] :
       {std::pair<std::string, std::string>{"drop", "drop.yaml: "},
        {"flat --set \"walk.path.segments=[{gait: stand, duration_s: 1}]\"", segments},
        {"flat --set \"walk.path.segments=[{gait: trot, yaw_rate_rad_per_s: 0.1, duration_s: 1}]\"",
         segments},
        {"flat --out there", "--out"},
        {"flat --graph there.svg", "--graph"}}) {
    const Result result = RunApp(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.text;
    EXPECT_THAT(result.text, ::testing::HasSubstr(place));
  }
}

}  // namespace tenon::tenon_gait_stability_test
