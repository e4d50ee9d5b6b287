#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/verdicts.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

namespace tenon::apps::verdicts_test {

using ::testing::ContainsRegex;

Summary SummaryOf(const PathVerdict& verdict) {
  RunOutcome outcome;
  outcome.status.time = 10;
  Summary summary("case", 1, outcome);
  verdict.AddTo(summary);
  return summary;
}

std::string Figure(const Summary& summary, const std::string& key) {
  const auto flat = summary.Flat();
  const auto found = std::ranges::find(flat, key, &std::pair<std::string, std::string>::first);
  return found == flat.end() ? "missing" : found->second;
}

TEST(PathVerdictTest, IsNullWithoutAPath) {
  PathVerdict none;
  none.Add(1, 100, 3);
  const Summary summary = SummaryOf(none);
  EXPECT_EQ(Figure(summary, "followed"), "");
  EXPECT_EQ(Figure(summary, "path_deviation_max_m"), "");
  EXPECT_TRUE(summary.finished());
}

TEST(PathVerdictTest, AllowsAShareOfTheLength) {
  PathVerdict verdict(0.1, 3);
  verdict.Add(1, 0.3, 0.1);
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "true");
  EXPECT_TRUE(SummaryOf(verdict).finished());
  verdict.Add(2, 0.30004, 0.1);
  verdict.Add(3, 0.2, 0.1);
  const Summary left = SummaryOf(verdict);
  EXPECT_EQ(Figure(left, "followed"), "false");
  EXPECT_FALSE(left.finished());
  EXPECT_EQ(left.exit_code(), kLimitBroken);
  EXPECT_THAT(Figure(left, "end_reason"), ContainsRegex("path.*0\\.30004 m.* 0\\.3 m.* 2 s"));
}

TEST(PathVerdictTest, AllowsAShareOfHalfATurn) {
  PathVerdict verdict(0.1, 3);
  verdict.Add(1, 0, 2 * std::numbers::pi - 0.3);  // 0.3 to the other side
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "true");
  verdict.Add(2, 0, -0.4);
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "false");
  EXPECT_THAT(Figure(SummaryOf(verdict), "end_reason"),
              ContainsRegex("heading.*0\\.4 rad.* 0\\.314 rad.* 2 s"));
}

// A turn on the spot has no length, so only the heading is judged.
TEST(PathVerdictTest, WithoutLengthTheHeadingCounts) {
  PathVerdict verdict(0.1, 0);
  verdict.Add(1, 0.5, 0);
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "true");
  verdict.Add(1, 0.5, 1);
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "false");
}

TEST(PathVerdictTest, ARobotMayStartAsideOfItsPath) {
  PathVerdict verdict(0.1, 3, 0.5, 1);
  verdict.Add(0, 0.7, 1.2);
  EXPECT_EQ(Figure(SummaryOf(verdict), "followed"), "true");
}

}  // namespace tenon::apps::verdicts_test
