#include <tenon/apps/common/run_options.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenon::apps::summary_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;

Summary Ran() {
  return {"a", 1, {.status = {.time = 1, .ended = false, .reason = ""}, .failure = "", .wall_s = 1}};
}

TEST(SummaryTest, NothingHappenedIsNull) {
  Summary summary = Ran();
  summary.Set("error_m", Tally().max());
  EXPECT_TRUE(summary.finished());
  EXPECT_EQ(summary.exit_code(), kRan);
  EXPECT_THAT(summary.Flat(), Contains(Pair("error_m", "")));
}

TEST(SummaryTest, AComputedNaNIsAnError) {
  Summary summary = Ran();
  Tally errors;
  for (const double error : {0.1, std::nan(""), 0.2}) errors.Add(error);
  summary.Set("error_m", errors.max());
  EXPECT_FALSE(summary.finished());
  EXPECT_EQ(summary.exit_code(), kNumericalFailure);
  EXPECT_THAT(summary.Flat(), Contains(Pair("error_m", "NaN")));
  EXPECT_THAT(summary.Flat(), Contains(Pair("end_reason", HasSubstr("error_m"))));
  Summary nested = Ran();
  nested.Set("foot_m", {{"left", 0.1}, {"right", std::nan("")}});
  EXPECT_EQ(nested.exit_code(), kNumericalFailure);
  EXPECT_THAT(nested.Flat(), Contains(Pair("end_reason", HasSubstr("foot_m.right"))));
}

TEST(SummaryTest, InfinityIsNotNull) {
  Summary summary = Ran();
  summary.Set("margin_m", std::numeric_limits<double>::infinity());
  EXPECT_THAT(summary.Flat(), Contains(Pair("margin_m", "Infinity")));
}

TEST(SummaryTest, WithoutWallClockTimeThereIsNoFactor) {
  Summary summary{"a", 1, {}};
  EXPECT_THAT(summary.Flat(), Contains(Pair("real_time_factor", "")));
}

}  // namespace tenon::apps::summary_test
