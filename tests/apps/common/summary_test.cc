#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/summary.h>
#include <tenon/tests/testing/block_test.h>

#include <array>
#include <tuple>
#include <utility>

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

// A bound of a task is a limit: a run that lasts until it is due is not finished beyond it.
TEST(SummaryTest, ATaskThatIsNotDoneFailsTheRun) {
  const auto judged = [](std::optional<double> climb, const Limits& limits, double due) {
    Summary summary = Ran();
    summary.Set("climb_m", climb);
    summary.Require("climb_m", limits, due);
    return std::pair(summary.finished(), summary.Flat());
  };
  const Limits high{.low = 0.5, .high = {}}, low{.low = {}, .high = 0.5};
  EXPECT_TRUE(judged(0.5, high, 1).first);
  EXPECT_TRUE(judged(0.5, low, 1).first);
  EXPECT_TRUE(judged(0, high, 1.1).first) << "the run ended before";
  EXPECT_TRUE(judged(0, {}, 0).first);
  for (const auto& [climb, limits, why] :
       {std::tuple(std::optional(0.4), high, "climb_m is 0.4, but must be at least 0.5"),
        {std::optional(0.50001), low, "climb_m is 0.50001, but must be at most 0.5"},
        {std::optional<double>(), Limits{}, "climb_m has no value"}}) {
    const auto [finished, flat] = judged(climb, limits, 1);
    EXPECT_FALSE(finished);
    EXPECT_THAT(flat, Contains(Pair("end_reason", HasSubstr(why))));
  }
  EXPECT_TRUE(Throws<KeyError>([] { Ran().Require("wall", {}, 0); }, "'wall'", "did you mean"));
}

TEST(TallyTest, IsEmptyWithoutValues) {
  const Tally none;
  EXPECT_EQ(none.min(), std::nullopt);
  EXPECT_EQ(none.max(), std::nullopt);
  EXPECT_EQ(none.mean(), std::nullopt);
  EXPECT_EQ(none.rms(), std::nullopt);
}

TEST(TallyTest, HasMinMaxMeanAndRms) {
  Tally tally;
  for (const double value : {-3.0, -1.0, -2.0}) tally.Add(value);
  EXPECT_EQ(tally.min(), -3);
  EXPECT_EQ(tally.max(), -1);
  EXPECT_EQ(tally.mean(), -2);
  EXPECT_DOUBLE_EQ(*tally.rms(), std::sqrt(14.0 / 3));
}

TEST(TallyTest, ANumberThatIsNoneIsNotSkipped) {
  for (const std::size_t at : {0, 1, 2}) {
    std::array<double, 3> values{-3, -1, -2};
    values[at] = NAN;
    Tally tally;
    for (const double value : values) tally.Add(value);
    for (const auto figure : {tally.min(), tally.max(), tally.mean(), tally.rms()})
      EXPECT_TRUE(figure && std::isnan(*figure)) << at;
  }
}

TEST(TimeQuantilesTest, AreExactToOnePercent) {
  TimeQuantiles times;
  EXPECT_EQ(times.Quantile(0.5), std::nullopt);
  for (int i = 1; i <= 1000; ++i) times.Add(1e-6 * i);
  for (const double share : {0.0, 0.25, 0.5, 0.99, 1.0})
    EXPECT_NEAR(*times.Quantile(share) / (1e-6 * (1 + share * 999)), 1, 0.01) << share;
}

TEST(TimeQuantilesTest, ClampValuesOutsideTheirRange) {
  TimeQuantiles times;
  times.Add(0);
  EXPECT_NEAR(*times.Quantile(1), 1e-9, 1e-11);
  times.Add(1e9);
  EXPECT_GT(*times.Quantile(1), 3600);
}

}  // namespace tenon::apps::summary_test
