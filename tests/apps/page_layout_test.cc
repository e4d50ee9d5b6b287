// Every part of the pages that the apps write is visible, see LayoutFaults.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/report/page_layout.h>

namespace tenon::page_layout_test {

namespace fs = std::filesystem;
using tenon::testing::Browser, ::testing::HasSubstr, ::testing::IsEmpty;

struct PageLayoutTest : test::AppTest {
  void SetUp() override { testing::RequireBrowser(); }
  /// Runs an app, which prints the path of its page.
  void Run(const std::string& app, const std::string& arguments, const fs::path& directory) const {
    const test::Result result = test::RunCommand(app + " " + arguments + " --out " + directory.string());
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(result.text, HasSubstr((directory / "report.html").string() + "\n"));
  }
  void ExpectLaidOut(const fs::path& directory, const std::string& ready) const {
    if (HasFatalFailure()) return;
    Browser browser;
    browser.Open(directory / "report.html");
    ASSERT_EQ(browser.Evaluate("!!(" + ready + ")"), true) << nlohmann::json(browser.complaints());
    EXPECT_THAT(testing::LayoutFaults(browser), IsEmpty());
    EXPECT_THAT(browser.complaints(), IsEmpty());
  }
};

constexpr const char* kRun = "window.tenonReport && tenonReport.ready && tenonReport.webgl";

TEST_F(PageLayoutTest, RunsOfEachApp) {
  for (const auto& [app, arguments] : {std::pair{TENON_QUADRUPED, "A1 --duration 0.8"},
                                       {TENON_GUIDE_DOG, "C1 --duration 0.3"},
                                       {TENON_CDPR, "D1 --duration 0.3"},
                                       {TENON_QUADRUPED, "A2 --compare --duration 0.1"}}) {
    SCOPED_TRACE(arguments);
    Run(app, arguments, out);
    ExpectLaidOut(out, kRun);
    fs::remove_all(out);
  }
}

TEST_F(PageLayoutTest, RunsOfTwoAppsBesideEachOther) {
  Run(TENON_QUADRUPED, "stand --duration 0.1", out / "stand");
  Run(TENON_CDPR, "D2 --controller pd --duration 0.1", out / "hang");
  Run(TENON_REPORT, (out / "stand").string() + " " + (out / "hang").string(), out / "both");
  ExpectLaidOut(out / "both", kRun);
}

TEST_F(PageLayoutTest, WorkspaceOfACableRobot) {
  Run(TENON_CDPR_WORKSPACE, "cogiro --cell 1 --turn 0.2", out);
  ExpectLaidOut(out, "window.tenonVolume && tenonVolume.ready && tenonVolume.webgl");
}

TEST_F(PageLayoutTest, Campaign) {
  const std::string file =
      Write("campaign_file.yaml",
            "app: tenon-quadruped\nscenario: A4\nduration_s: 0.05\nseeds: {count: 3}\n"
            "vary: {random_forces.0.upper_N: {grid: [20, 35]}, walk.friction: {grid: [0.3, 0.6]}}\n");
  Run(TENON_CAMPAIGN, file, out / "runs");
  ExpectLaidOut(out / "runs", "window.tenonCampaign && tenonCampaign.ready");
}

}  // namespace tenon::page_layout_test
