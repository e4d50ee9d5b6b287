#include <tenon/apps/common/tally.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace tenon::apps::tally_test {
namespace {

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

}  // namespace
}  // namespace tenon::apps::tally_test
