// The pages that the apps write, from short runs: whether all of each can be seen, see LayoutFaults.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/report/page_layout.h>

#include <cstdlib>

namespace tenon::page_layout_test {
namespace {

namespace fs = std::filesystem;
using tenon::testing::Browser;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class PageLayoutTest : public test::AppTest {
 protected:
  void SetUp() override {
    if (Browser::IsInstalled()) return;
    if (std::getenv("TENON_REQUIRE_BROWSER") != nullptr) FAIL() << "chromium is missing: tools/install_deps";
    GTEST_SKIP() << "needs chromium";
  }
  /// Runs an app, which says where its page is.
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

TEST_F(PageLayoutTest, WalkOfAQuadruped) {
  Run(TENON_QUADRUPED, "A1 --duration 0.8", out);
  ExpectLaidOut(out, kRun);
}

TEST_F(PageLayoutTest, WalkOfAGuideDog) {
  Run(TENON_GUIDE_DOG, "C1 --duration 0.3", out);
  ExpectLaidOut(out, kRun);
}

TEST_F(PageLayoutTest, FlightOfACableRobot) {
  Run(TENON_CDPR, "D1 --duration 0.3", out);
  ExpectLaidOut(out, kRun);
}

TEST_F(PageLayoutTest, ComparisonOfEightWalks) {
  Run(TENON_QUADRUPED, "A3-sweep --duration 0.1 --set sweep.phases=2 --set sweep.directions=4", out);
  ExpectLaidOut(out, kRun);
}

TEST_F(PageLayoutTest, RunsOfTwoAppsBesideEachOther) {
  Run(TENON_QUADRUPED, "stand --duration 0.1", out / "stand");
  Run(TENON_CDPR, "D2 --controller pd --duration 0.1", out / "hang");
  Run(TENON_REPORT, (out / "stand").string() + " " + (out / "hang").string(), out / "both");
  ExpectLaidOut(out / "both", kRun);
}

TEST_F(PageLayoutTest, OrdersOfAnObserver) {
  Run(TENON_OBSERVER_ORDER, "A0 --duration 0.25", out);
  ExpectLaidOut(out, kRun);
}

TEST_F(PageLayoutTest, WorkspaceOfACableRobot) {
  Run(TENON_CDPR_WORKSPACE, "cogiro --cell 1 --turn 0.2", out);
  ExpectLaidOut(out, "window.tenonVolume && tenonVolume.ready && tenonVolume.webgl");
}

TEST_F(PageLayoutTest, Campaign) {
  fs::create_directories(out);
  const fs::path file = out / "campaign_file.yaml";
  std::ofstream(file)
      << "app: tenon-quadruped\nscenario: A4\nduration_s: 0.05\nseeds: {count: 3}\n"
         "vary: {random_forces.0.upper_N: {grid: [20, 35]}, walk.friction: {grid: [0.3, 0.6]}}\n";
  Run(TENON_CAMPAIGN, file.string(), out / "runs");
  ExpectLaidOut(out / "runs", "window.tenonCampaign && tenonCampaign.ready");
}

}  // namespace
}  // namespace tenon::page_layout_test
