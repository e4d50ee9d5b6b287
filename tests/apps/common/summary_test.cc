#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/real_time.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/tests/testing/block_test.h>

#include <csignal>
#include <numbers>
#include <tuple>

namespace tenon::apps::summary_test {

using apps::FigureColumns, apps::FigureLines, apps::FigureTexts, apps::NamedTexts, apps::NumberText,
    ::testing::Contains, ::testing::ContainsRegex, ::testing::HasSubstr, ::testing::Pair;

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

TEST(SummaryTest, BoundsOfForcesAndOfTheClimbFollowTheSizeOfTheRobot) {
  const auto finished = [](const std::string& key, double value, double weight, double length) {
    Summary summary = Ran();
    summary.Set(key, value);
    Task{.figures = {{key, {.at_least = 0.5, .at_most = 1}}}, .due_s = {}}.AddTo(summary, 0, weight, length);
    return summary.finished();
  };
  for (const auto& [key, factor] :
       {std::pair("tension_max_N", 4.0), {"force_error_N.x", 4.0}, {"climb_m", 0.25}, {"drift_m", 1.0}}) {
    for (const double bound : {0.5, 1.0}) {
      const double inside = bound == 1 ? 0.99 : 1.01;
      EXPECT_TRUE(finished(key, inside * factor * bound, 4, 0.25)) << key;
      EXPECT_FALSE(finished(key, factor * bound / inside, 4, 0.25)) << key;
    }
  }
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

TEST(TimeQuantilesTest, CountTimesBelowALimit) {
  TimeQuantiles times;
  for (const int time : {1, 10, 10, 100}) times.Add(1e-6 * time);
  EXPECT_EQ(times.Below(5e-6), 1);
  EXPECT_EQ(times.Below(5e-5), 3);
  EXPECT_EQ(times.Below(1), times.count());
}

TEST(RealTimeTest, ANamedMachineWithMeasuredTicks) {
  const std::string text = ExamineRealTime(0.01).first;
  for (const char* part :
       {"kernel", "isolated", "500 Hz", "1000 Hz", " of 5 ticks missed", " of 10 ticks missed"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(TimeQuantilesTest, ClampValuesOutsideTheirRange) {
  TimeQuantiles times;
  times.Add(0);
  EXPECT_NEAR(*times.Quantile(1), 1e-9, 1e-11);
  times.Add(1e9);
  EXPECT_GT(*times.Quantile(1), 3600);
}

TEST(FigureTextTest, NumbersHaveFourDigits) {
  EXPECT_EQ(NumberText(0.0011560582642818895), "0.001156");
  EXPECT_EQ(NumberText(-1234.5678), "-1235");
  EXPECT_EQ(NumberText(148412.3), "148400");
  EXPECT_EQ(NumberText(2.5e-7), "2.5e-07");
  EXPECT_EQ(NumberText(1.23456e7), "12345600") << "a whole number";
  EXPECT_EQ(NumberText(1.2345678e7 + 0.5), "1.235e+07");
  EXPECT_EQ(NumberText(-0.0), "0");
  EXPECT_EQ(NumberText(NAN), "-");
}

// Nothing happened, or something that has no number.
TEST(FigureTextTest, NoValueIsNotNaN) {
  const auto figures = FigureTexts({{"a_m", ""}, {"b_m", "NaN"}, {"c_m", "Infinity"}});
  EXPECT_EQ(figures.at(0).values.at(0).second, "-");
  EXPECT_EQ(figures.at(1).values.at(0).second, "NaN");
  EXPECT_EQ(figures.at(2).values.at(0).second, "Infinity");
}

TEST(FigureTextTest, ValuesOfLegsAreATable) {
  const NamedTexts flat{{"case", "A1"},
                        {"seed", "18446744073709551615"},
                        {"foot_error_max_m.front_left", "0.0011560582642818895"},
                        {"foot_error_max_m.rear_right", ""},
                        {"com_error_max_m", "0.02"},
                        {"slip_max_m.front_left", "0.00022829782782513656"},
                        {"slip_max_m.rear_right", "1"},
                        {"force_estimate_mean_N.x", "8.772805595394102"},
                        {"force_estimate_mean_N.y", "-1234.5678"}};
  std::vector<apps::FigureText> figures = FigureTexts(flat);
  ASSERT_EQ(figures.size(), 6);
  figures[3].limit = figures[4].limit = "   (at most 0.1)";
  EXPECT_EQ(FigureLines(figures), R"(case                   A1
seed                   18446744073709551615
com_error_max_m        0.02 m   (at most 0.1)

                         front_left  rear_right
foot_error_max_m           0.001156           - m
slip_max_m                0.0002283           1 m   (at most 0.1)

                                  x           y
force_estimate_mean_N         8.773       -1235 N
)");
}

TEST(FigureTextTest, TablesThatAreTooWideAreLines) {
  NamedTexts flat;
  for (int i = 0; i < 12; ++i) flat.emplace_back("tension_max_N.cable_" + std::to_string(i), "100.5");
  const std::string lines = FigureLines(FigureTexts(flat));
  EXPECT_THAT(lines, ::testing::StartsWith("tension_max_N.cable_0  100.5 N\n"));
  EXPECT_EQ(std::ranges::count(lines, '\n'), 12);
}

TEST(FigureTextTest, RunsAreColumns) {
  const std::string columns =
      FigureColumns({{"none", {{"error_m", "0.123456"}, {"end_reason", "end of the run"}}},
                     {"a very long name of a variant",
                      {{"error_m", ""},
                       {"end_reason", "the robot fell: its trunk is below 0.2 m"},
                       {"slip_m.left", "2"}}}});
  EXPECT_EQ(columns, R"(                       none  a very long name of a v…
error_m              0.1235                         - m
end_reason   end of the run  the robot fell: its tru…
slip_m.left               -                         2 m
)");
}

TEST(FigureTextTest, ManyRunsStandBelowEachOther) {
  const std::pair<std::string, NamedTexts> run{"a_run", {{"error_m", "1"}}};
  const std::string columns = FigureColumns(std::vector(20, run));
  EXPECT_EQ(std::ranges::count(columns, '\n'), 3 * 2 + 2) << "20 columns of 12 characters are three tables";
  std::size_t longest = 0;
  for (std::size_t begin = 0, end; (end = columns.find('\n', begin)) != columns.npos; begin = end + 1)
    longest = std::max(longest, end - begin);
  EXPECT_LE(longest, 122);
}

using apps::Beside;
using Texts = std::pair<std::string, std::string>;

TEST(BesideTest, TakesEnoughDigitsToDiffer) {
  EXPECT_EQ(Beside(7.1234, 5), Texts("7.12", "5"));
  EXPECT_EQ(Beside(5.0004, 5), Texts("5.0004", "5"));
  EXPECT_EQ(Beside(4.9999996, 5, 4), Texts("4.9999996", "5"));
  EXPECT_EQ(Beside(1 + 1e-15, 1), Texts("1.000000000000001", "1"));
}

TEST(BesideTest, EqualOnesAreShort) {
  EXPECT_EQ(Beside(0.005, 0.005), Texts("0.005", "0.005"));
  EXPECT_EQ(Beside(1.0 / 3, 1.0 / 3), Texts("0.333", "0.333"));
}

Summary SummaryOf(const PathVerdict& verdict) {
  Summary summary("case", 1, {.status = {.time = 10}});
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

std::string Said(const std::string& text) {
  ::testing::internal::CaptureStderr();
  Say(text);
  return ::testing::internal::GetCapturedStderr();
}

TEST(SayTest, ControlCharactersDoNotReachATerminal) {
  EXPECT_EQ(Said("warning: na\xc3\xafve\n"), "warning: na\xc3\xafve\n");
  EXPECT_EQ(Said("\033[31mred\r\n"), "\\x1b[31mred\\x0d\n");
  EXPECT_EQ(Said("\xc2\x9b"
                 "31m"),
            "\\x9b31m")
      << "the same in one character of two bytes";
  EXPECT_EQ(Said("caf\xe9 \xff"), "caf\\xe9 \\xff") << "not UTF-8";
  EXPECT_EQ(Said("cut \xe2\x80"), "cut \\xe2\\x80") << "a character without its end";
}

TEST(SayTest, DrawnLinesKeepControlSequences) {
  ::testing::internal::CaptureStderr();
  Draw("\r\033[K");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "\r\033[K");
}

TEST(SignalDeathTest, EndsARunInsideACalculationThatDoesNotReturn) {
  DiagramBuilder builder;
  builder.AddFunction("endless", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    if (t < 0.5) return t;
    std::raise(SIGTERM);
    for (volatile bool on = true; on;) continue;
    return t;
  });
  Simulator simulator(builder.Build());
  EXPECT_EXIT(Observe(simulator, [&] { return simulator.AdvanceTo(1); }),
              ::testing::ExitedWithCode(128 + SIGTERM), "does not end");
}

TEST(SignalTest, EndsARunAfterTheStepThatItInterrupts) {
  DiagramBuilder builder;
  builder.AddFunction("signal", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    if (t == 0.5) std::raise(SIGTERM);
    return t;
  });
  Simulator simulator(builder.Build());
  const RunOutcome outcome = Advance(simulator, 10);
  EXPECT_EQ(outcome.exit_code, 128 + SIGTERM);
  EXPECT_LT(outcome.status.time, 1);
}

}  // namespace tenon::apps::summary_test
