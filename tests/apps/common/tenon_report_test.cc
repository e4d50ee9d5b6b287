// A page with several runs.

#include <tenon/tests/apps/browser_app.h>
#include <tenon/tests/apps/run_app.h>

namespace tenon::tenon_report_test {
namespace {

namespace fs = std::filesystem;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_REPORT) + " " + arguments);
}

class TenonReportTest : public test::AppTest {
 protected:
  /// Two short flights, of different scenarios.
  void Fly() {
    for (const auto& [name, scenario] : {std::pair{"circle", "D1"}, {"hang", "D2"}}) {
      const Result result = RunCommand(std::string(TENON_CDPR) + " " + scenario +
                                       " --controller pd --duration 0.2 --out " + (out / name).string());
      ASSERT_EQ(result.exit_code, 0) << result.text;
    }
  }
  std::string Directory(const std::string& name) const { return (out / name).string(); }
};

TEST_F(TenonReportTest, PutsRunsSideBySide) {
  Fly();
  const fs::path page = out / "both" / "report.html";
  const Result result =
      RunApp(Directory("circle") + "/ " + Directory("hang") + " --out " + page.parent_path().string());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_EQ(result.text, page.string() + "\n");
  test::RequireBrowser();
  if (IsSkipped() || HasFatalFailure()) return;
  testing::Browser browser;
  browser.Open(page);
  EXPECT_EQ(browser.Evaluate("tenonReport.ready"), true) << Json(browser.complaints());
  EXPECT_EQ(browser.Evaluate("document.querySelector('h1').textContent"), "circle, hang");
  EXPECT_EQ(browser.Evaluate("tenonReport.runs.map((run) => run.name)"), Json({"circle", "hang"}));
  EXPECT_EQ(browser.Evaluate("tenonReport.replay.runs.map((run) => run.actors.length > 5)"),
            Json({true, true}));
  // Each run keeps its figures and its signals.
  const Json summary = Json::parse(test::Read(out / "hang" / "summary.json"));
  EXPECT_EQ(browser.Evaluate("tenonReport.runs[1].figures.find((f) => f.name === 'tension_max_N').value"),
            summary["tension_max_N"]);
  const auto logged = test::Column(out / "circle", "loop.plant.cables.tension.2 [N]");
  const Json shown =
      browser.Evaluate("[...tenonReport.runs[0].find('loop.plant.cables.tension.2')[0].values]");
  ASSERT_EQ(shown.size(), logged.size());
  for (std::size_t i = 0; i < logged.size(); ++i)
    EXPECT_FLOAT_EQ(shown[i].get<float>(), static_cast<float>(logged[i]));
  EXPECT_EQ(browser.Evaluate("tenonReport.runs[0].limitsOf('loop.command.0').high"), 800);
  EXPECT_TRUE(browser.complaints().empty()) << Json(browser.complaints());
}

TEST_F(TenonReportTest, RefusesBadUsage) {
  Fly();
  EXPECT_THAT(RunApp("--help").text, AllOf(HasSubstr("DIR"), HasSubstr("--out"), HasSubstr("Exit codes")));
  const std::string circle = Directory("circle"), hang = Directory("hang");
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += circle + " ";
  fs::create_directories(out / "taken");
  const std::string taken = Directory("taken");
  for (const auto& [arguments, place] : {std::pair{std::string(), std::string("DIR")},
                                         {Directory("nowhere"), "'" + Directory("nowhere") + "'"},
                                         {out.string(), "'" + out.string() + "' has no report.html"},
                                         {circle + " " + hang + " --out " + circle, "'" + circle + "'"},
                                         {nine, "9 runs"}}) {
    const Result result = RunApp(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.text, HasSubstr(place));
  }
  EXPECT_EQ(RunCommand("flock " + taken + " " TENON_REPORT " " + circle + " --out " + taken).exit_code, 2);
  EXPECT_EQ(RunApp(circle + " --out /proc/none").exit_code, 5);
  fs::remove(out / "hang" / "signals.csv");
  EXPECT_THAT(RunApp(circle + " " + hang).text, HasSubstr("'" + hang + "' has no signals.csv"));
}

}  // namespace
}  // namespace tenon::tenon_report_test
