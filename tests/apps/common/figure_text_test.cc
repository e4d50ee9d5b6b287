#include <tenon/apps/common/figure_text.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tenon::figure_text_test {

using apps::FigureColumns;
using apps::FigureLines;
using apps::FigureTexts;
using apps::NamedTexts;
using apps::NumberText;

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

}  // namespace tenon::figure_text_test
