// Runs the binary as its users do.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/report/browser.h>

#include <cstdlib>

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
  if (!testing::Browser::IsInstalled()) {
    ASSERT_EQ(std::getenv("TENON_REQUIRE_BROWSER"), nullptr) << "chromium is missing: tools/install_deps";
    GTEST_SKIP() << "needs chromium";
  }
  testing::Browser browser;
  browser.Open(page);
  EXPECT_EQ(browser.Evaluate("tenonReport.ready"), true) << Json(browser.complaints());
  EXPECT_EQ(browser.Evaluate("document.querySelector('h1').textContent"), "circle, hang");
  EXPECT_EQ(browser.Evaluate("tenonReport.runs.map((run) => run.name)"), Json({"circle", "hang"}));
  EXPECT_EQ(browser.Evaluate("tenonReport.replay.runs.map((run) => run.actors.length > 5)"),
            Json({true, true}));
  // What each run had of its own: figures, and every signal as it was logged.
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

TEST_F(TenonReportTest, SaysWhatIsMissingWhere) {
  Fly();
  EXPECT_THAT(RunApp("--help").text, AllOf(HasSubstr("DIR"), HasSubstr("--out"), HasSubstr("Exit codes")));
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Result result = RunApp(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.text, HasSubstr(message));
  };
  refused("", "DIR is required");
  refused(Directory("nowhere"), "'" + Directory("nowhere") + "' is not a directory");
  refused(out.string(), "'" + out.string() + "' has no report.html");
  refused(Directory("circle") + " " + Directory("hang") + " --out " + Directory("circle"),
          "'" + Directory("circle") + "' is one of the runs");
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += Directory("circle") + " ";
  refused(nine, "9 runs");
  fs::remove(out / "hang" / "signals.csv");
  refused(Directory("circle") + " " + Directory("hang"), "'" + Directory("hang") + "' has no signals.csv");
  fs::create_directories(out / "taken");
  const std::string taken = (out / "taken").string();
  const Result locked =
      RunCommand("flock " + taken + " " TENON_REPORT " " + Directory("circle") + " --out " + taken);
  EXPECT_EQ(locked.exit_code, 2);
  EXPECT_THAT(locked.text, HasSubstr("another run writes into the output directory"));
  const Result full = RunApp(Directory("circle") + " --out /proc/none");
  EXPECT_EQ(full.exit_code, 5);
  EXPECT_THAT(full.text, HasSubstr("output directory '/proc/none'"));
}

}  // namespace
}  // namespace tenon::tenon_report_test
