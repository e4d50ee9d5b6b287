#include <tenon/systems/framework/block/internal/rational.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::rate_test {

TEST(RateTest, DecimalsAreTakenAsWritten) {
  EXPECT_EQ(Hz(1000), Rate::FromPeriod(1, 1000));
  EXPECT_EQ(Hz(300), Rate::FromPeriod(1, 300));
  EXPECT_EQ(Hz(29.97), Rate::FromPeriod(100, 2997));
  EXPECT_EQ(Hz(0.1), Rate::FromPeriod(10, 1));
  EXPECT_EQ(Hz(1.0 / 3), Rate::FromPeriod(3, 1));
  EXPECT_EQ(Seconds(2.5), Rate::FromPeriod(5, 2));
  EXPECT_EQ(Milliseconds(2.5), Rate::FromPeriod(1, 400));
  EXPECT_EQ(Milliseconds(260), Rate::FromPeriod(13, 50));
  EXPECT_EQ(Seconds(1.0 / 30), Hz(30));
  EXPECT_EQ(Milliseconds(0.001), Rate::FromPeriod(1, 1000000));
}

TEST(RateTest, ReachesFromZeroToABillionHertz) {
  EXPECT_EQ(Hz(1e9), Rate::FromPeriod(1, 1'000'000'000));
  EXPECT_THROW(Hz(1.0001e9), ParameterError);
}

TEST(RateTest, IsReduced) {
  EXPECT_EQ(Rate::FromPeriod(4, 400), Rate::FromPeriod(1, 100));
  EXPECT_EQ(Rate::FromPeriod(4, 400).numerator(), 1);
  EXPECT_EQ(Rate::FromPeriod(4, 400).denominator(), 100);
  EXPECT_EQ(Hz(300).period(), 1.0 / 300);
  EXPECT_EQ(Hz(29.97).hz(), 29.97);
  EXPECT_EQ(ToString(Hz(29.97)), "29.97 Hz");
}

TEST(RateTest, WhatIsNoRateIsRefused) {
  for (const double bad :
       {0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(Throws<ParameterError>([&] { Hz(bad); }, " Hz"));
    EXPECT_TRUE(Throws<ParameterError>([&] { Seconds(bad); }, " s"));
    EXPECT_THROW(Milliseconds(bad), ParameterError);
  }
  EXPECT_TRUE(Throws<ParameterError>([] { Rate::FromPeriod(0, 5); }, "0/5 s"));
  EXPECT_TRUE(Throws<ParameterError>([] { Rate::FromPeriod(1, -5); }, "1/-5 s"));
  EXPECT_TRUE(Throws<ParameterError>([] { Hz(1e10); }, "10000000000 Hz"));
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
  EXPECT_TRUE(Throws<ParameterError>([] { Rate::FromPeriod(kLargest, 1); }, "out of range"));
  EXPECT_TRUE(Throws<ParameterError>([] { Rate::FromPeriod(1, kLargest); }, "out of range"));
}

TEST(RateTest, WhatIsNoFractionOfTwelveDigitsIsRefused) {
  EXPECT_TRUE(Throws<ParameterError>([] { Hz(0.03141592653589793); }, "0.03141592653589793 Hz"));
  EXPECT_TRUE(Throws<ParameterError>([] { Seconds(0.01414213562373095); }, "0.01414213562373095 s"));
  EXPECT_NEAR(Hz(31.41592653589793).hz(), 31.41592653589793, 1e-10);  // a large number is one soon
}

TEST(RateTest, OffsetsMayBeZero) {
  EXPECT_EQ(internal::ToRational(0, "an offset"), (internal::Rational{0, 1}));
  EXPECT_EQ(internal::ToRational(0.0125, "an offset"), (internal::Rational{1, 80}));
  EXPECT_TRUE(Throws<ParameterError>([] { internal::ToRational(-1, "an offset"); }, "an offset of -1 s"));
}

}  // namespace tenon::rate_test
