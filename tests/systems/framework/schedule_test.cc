#include <tenon/systems/framework/diagram/internal/schedule.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::internal::schedule_test {

using ::testing::HasSubstr, ::testing::ThrowsMessage;

TEST(ScheduleTest, WithoutEntriesThereIsNoTick) {
  EXPECT_EQ(Schedule({}).next_time(), std::numeric_limits<double>::infinity());
}

TEST(ScheduleTest, TicksOfTwoRatesMeetExactly) {
  Schedule schedule({{{1, 300}, {0, 1}, "a"}, {{1, 1000}, {0, 1}, "b"}});
  int counts[2] = {0, 0}, together = 0;
  while (schedule.next_time() < 10) {
    const double time = schedule.next_time();
    const Groups due = schedule.Take();
    for (const int i : due) ++counts[i];
    if (due.size() != 2) continue;
    EXPECT_EQ(time, together / 100.0);
    ++together;
  }
  EXPECT_EQ(counts[0], 3000);
  EXPECT_EQ(counts[1], 10000);
  EXPECT_EQ(together, 1000);
}

TEST(ScheduleTest, OffsetsMayExceedThePeriod) {
  Schedule schedule({{{1, 10}, {1, 4}, "late"}, {{1, 10}, {0, 1}, "soon"}});
  std::vector<std::pair<double, Groups>> ticks;
  for (int i = 0; i < 5; ++i) {
    const double time = schedule.next_time();
    ticks.emplace_back(time, schedule.Take());
  }
  using testing::ElementsAre, testing::Pair;
  EXPECT_THAT(ticks,
              ElementsAre(Pair(0, ElementsAre(1)), Pair(0.1, ElementsAre(1)), Pair(0.2, ElementsAre(1)),
                          Pair(0.25, ElementsAre(0)), Pair(0.3, ElementsAre(1))));
}

TEST(ScheduleTest, MovesToWhatComesAfterATime) {
  Schedule schedule({{{1, 300}, {0, 1}, "a"}});
  for (const int tick : {0, 1, 7, 100, 1000003}) {
    const double time = tick / 300.0, next = (tick + 1) / 300.0;
    schedule.MoveTo(time, true);
    EXPECT_EQ(schedule.next_time(), time);
    schedule.MoveTo(time, false);
    EXPECT_EQ(schedule.next_time(), next);
    for (const bool inclusive : {true, false}) {  // the nearest doubles are other times
      schedule.MoveTo(std::nextafter(time, 1e9), inclusive);
      EXPECT_EQ(schedule.next_time(), next);
      if (tick == 0) continue;
      schedule.MoveTo(std::nextafter(time, 0), inclusive);
      EXPECT_EQ(schedule.next_time(), time);
    }
  }
}

TEST(ScheduleTest, MoveToKeepsOffsets) {
  Schedule schedule({{{1, 10}, {1, 4}, "a"}});
  schedule.MoveTo(0.1, true);
  EXPECT_EQ(schedule.next_time(), 0.25);
  schedule.MoveTo(0.25, false);
  EXPECT_EQ(schedule.next_time(), 0.35);
  schedule.MoveTo(7.3, true);
  EXPECT_EQ(schedule.next_time(), 7.35);
}

TEST(ScheduleTest, KnowsWhenTheIntegratorHasToStartAgain) {
  Schedule schedule({{{1, 10}, {0, 1}, "sensor"}, {{1, 4}, {0, 1}, "controller", true}});
  EXPECT_EQ(schedule.next_feeding_time(), 0);
  schedule.Take();
  EXPECT_EQ(schedule.next_time(), 0.1);
  EXPECT_EQ(schedule.next_feeding_time(), 0.25);
  EXPECT_EQ(Schedule({{{1, 10}, {0, 1}, "sensor"}}).next_feeding_time(),
            std::numeric_limits<double>::infinity());
}

TEST(ScheduleTest, PeriodsWithoutACommonTickAreRefused) {
  const auto refused = ThrowsMessage<BuildError>(HasSubstrs("'a'", "'b'", "tick"));
  EXPECT_THAT([] { Schedule({{{1, 99999999977}, {0, 1}, "a"}, {{1, 99999999947}, {0, 1}, "b"}}); }, refused);
  // Denominators whose common multiple exceeds 64 bits.
  EXPECT_THAT([] { Schedule({{{1, 3}, {0, 1}, "a"}, {{1, std::int64_t{1} << 62}, {0, 1}, "b"}}); }, refused);
}

// The common tick of 1 MHz and 999999 Hz is close to a picosecond, of which 64 bits count 107 days.
TEST(ScheduleTest, TicksThatCannotBeCountedAreRefused) {
  const auto refused = [](const std::string& where) { return ThrowsMessage<Error>(HasSubstr(where)); };
  const SampleGroup fast{{1, 1'000'000}, {0, 1}, "fast"}, uneven{{1, 999'999}, {0, 1}, "uneven"};
  EXPECT_THAT(([&] { Schedule({fast, uneven, {{1'000'000'000, 1}, {0, 1}, "slow"}}); }), refused("'slow'"));
  EXPECT_THAT(([&] { Schedule({fast, uneven, {{1, 1}, {1'000'000'000, 1}, "late"}}); }), refused("'late'"));
  Schedule schedule({fast, uneven});
  EXPECT_THAT([&] { schedule.MoveTo(9.3e6, true); }, refused("too late"));
  EXPECT_THAT([&] { schedule.MoveTo(1e308, true); }, refused("too late"));
  Schedule seldom({{{1'000'000'000, 1}, {0, 1}, "seldom"}, {{1, 1'000'000'000}, {0, 1}, "often"}});
  EXPECT_EQ(seldom.Take(), (Groups{0, 1}));
  EXPECT_EQ(seldom.next_time(), 1e-9);
}

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

}  // namespace tenon::internal::schedule_test
