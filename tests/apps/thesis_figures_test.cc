// Every figure of the thesis is made by its command.

#include <tenon/apps/common/command_line.h>
#include <tenon/tests/apps/run_app.h>

#include <set>

namespace tenon::thesis_figures_test {

namespace fs = std::filesystem;
using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

const std::map<std::string, std::string> kApps{
    {"tenon-quadruped", TENON_QUADRUPED}, {"tenon-guide-dog", TENON_GUIDE_DOG}, {"tenon-cdpr", TENON_CDPR}};

const std::vector<apps::ThesisFigure>& Figures() {
  static const auto figures = apps::LoadFigures("thesis");
  return figures;
}

// Chapters 2 and 3 have results in these figures; 2.29, 3.1 and 3.2 are drawings and a photograph.
TEST(ThesisFiguresTest, AreAllFiguresOfResults) {
  std::set<std::string> numbers{"2.28"};
  for (int i = 3; i <= 37; ++i)
    if (i != 29) numbers.insert("2." + std::to_string(i));
  for (int i = 3; i <= 9; ++i) numbers.insert("3." + std::to_string(i));
  std::set<std::string> found;
  const std::string page = ReadText(fs::path(TENON_DOCS) / "thesis_figures.md");
  for (const auto& figure : Figures()) {
    EXPECT_TRUE(found.insert(figure.number).second) << figure.number << " appears twice";
    EXPECT_FALSE(figure.plots.empty() && figure.pictures_s.empty()) << figure.number;
    EXPECT_THAT(page, HasSubstrs(figure.app + " --figure " + figure.number + "`", figure.thesis));
  }
  EXPECT_EQ(found, numbers);
}

struct ThesisFiguresAppTest : test::AppTest {
  ThesisFiguresAppTest() : AppTest(TENON_QUADRUPED) {}
};

TEST_F(ThesisFiguresAppTest, AreListedWithoutANumberAndForAnUnknownOne) {
  EXPECT_THAT(Run("--figure"), AllOf(HasSubstrs("2.19   A6 ", "2.5 "), Not(HasSubstr("2.30"))));
  EXPECT_THAT(Run("--figure 2.99", 2), HasSubstrs("--figure 2.99", "2.19   A6 "));
  EXPECT_THAT(Run("--figure 2.30", 2), HasSubstr("tenon-guide-dog --figure 2.30"));
  ExpectRefused({{"A6 --figure 2.19", "--figure"}, {"--figure 2.19 --live", "--live"}});
}

struct EveryFigureTest : test::AppTest, ::testing::WithParamInterface<apps::ThesisFigure> {
  EveryFigureTest() : AppTest(kApps.at(GetParam().app)) {}
};
std::string NumberOf(const ::testing::TestParamInfo<apps::ThesisFigure>& info) {
  std::string name = "Figure" + info.param.number;
  std::ranges::replace(name, '.', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Cases, EveryFigureTest, ::testing::ValuesIn(Figures()), NumberOf);

TEST_P(EveryFigureTest, RunsForASecondAndSavesItsPlots) {
  const apps::ThesisFigure& figure = GetParam();
  const std::string printed = Run("--figure " + figure.number + " --duration 1");
  EXPECT_THAT(printed,
              HasSubstrs("Figure " + figure.number + ": " + figure.title, figure.thesis, "report.html"));
  if (printed.find("install Chromium") != printed.npos) return;
  std::size_t drawings = 0;
  if (fs::exists(out / "figure"))
    for (const auto& file : fs::directory_iterator(out / "figure"))
      drawings +=
          file.path().extension() == ".svg" && ReadText(file.path()).find("<path") != std::string::npos;
  EXPECT_EQ(drawings, figure.plots.size());
  for (std::size_t i = 1; i <= figure.pictures_s.size(); ++i)
    EXPECT_GT(fs::file_size(out / ("picture_" + std::to_string(i) + ".png")), 10'000);
}

}  // namespace tenon::thesis_figures_test
