// The report of a short flight, opened from disk in a browser without network.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/report/browser.h>

#include <array>
#include <memory>

namespace tenon::report_page_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr, ::testing::IsEmpty;
using Json = nlohmann::json;
using tenon::testing::Browser;

struct ReportPageTest : ::testing::Test {
  static void SetUpTestSuite() {
    out = test::TemporaryPath("tenon_ReportPageTest");
    const test::Result result =
        test::RunCommand(std::string(TENON_CDPR) +
                         " D1 --duration 2 --set 'payload={mass_kg: 3, position_m: [0.05, "
                         "0, 0.1], attach_s: 0.5, release_s: 1.5}' --out " +
                         out.string());
    ASSERT_EQ(result.exit_code, 0) << result.text;
  }
  static void TearDownTestSuite() { fs::remove_all(out); }
  static fs::path out;

  void SetUp() override {
    testing::RequireBrowser();
    if (!IsSkipped() && !HasFatalFailure()) Open({});
  }
  void Open(const std::vector<std::string>& browser_arguments) {
    browser_ = std::make_unique<Browser>(browser_arguments);
    browser().Open(out / "report.html");
    // The page is complete once it is loaded.
    ASSERT_EQ(browser().Evaluate("!!window.tenonReport && tenonReport.ready"), true)
        << Json(browser().complaints()).dump();
  }
  Browser& browser() { return *browser_; }

 private:
  std::unique_ptr<Browser> browser_;
};
fs::path ReportPageTest::out;

TEST_F(ReportPageTest, ShowsVerdictAndFigures) {
  const Json summary = Json::parse(std::ifstream(out / "summary.json"));
  EXPECT_THAT(browser().Evaluate("document.querySelector('h1').textContent").get<std::string>(),
              HasSubstr("D1"));
  EXPECT_EQ(browser().Evaluate("document.querySelector('.verdict.good').textContent"), "finished after 2 s");
  const Json shown = browser().Evaluate(
      "Object.fromEntries([...document.querySelectorAll('#figures tr')].map((row) => "
      "[row.cells[0].title, [row.cells[1].textContent, row.cells[2].textContent]]))");
  ASSERT_TRUE(shown.contains("tracking_error_rms_m"));
  const double error = summary.at("tracking_error_rms_m");
  EXPECT_NEAR(std::stod(shown["tracking_error_rms_m"][0].get<std::string>()), 1e3 * error, error);
  EXPECT_EQ(shown["tracking_error_rms_m"][1], "mm") << "small lengths are in millimetres";
  EXPECT_EQ(shown.size(), summary.size() - 4)
      << "finished, fell and end_reason are the verdict, limits stand beside their figures";
}

TEST_F(ReportPageTest, ShapesAreWhereTheRunHadThem) {
  // Columns of signals.csv: time, position of the CoM; the row at t = 1 s.
  std::ifstream csv(out / "signals.csv");
  std::string line;
  while (std::getline(csv, line) && !line.starts_with("1,")) {
  }
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(line.c_str(), "1,%lf,%lf,%lf", &x, &y, &z), 3) << line;

  browser().Evaluate("tenonReport.seek(1)");
  const Json shapes =
      browser().Evaluate(R"(Object.fromEntries(tenonReport.replay.runs[0].actors.map((actor) => {
    const at = (y) => actor.object.localToWorld(new THREE.Vector3(0, y, 0)).toArray();
    actor.object.updateMatrixWorld();
    const length = actor.shape.kind === 'segment' ? actor.object.children[0].scale.y : 0;
    return [actor.shape.name, {from: at(0), to: at(length), visible: actor.object.visible}];
  })))");
  const auto near = [](const Json& p, std::array<double, 3> q) {
    return std::hypot(p[0].get<double>() - q[0], p[1].get<double>() - q[1], p[2].get<double>() - q[2]) < 1e-5;
  };
  EXPECT_TRUE(near(shapes["platform"]["from"], {x, y, z})) << shapes["platform"];
  EXPECT_TRUE(near(shapes["cable 0"]["to"], {3.5, 4.5, 4})) << shapes["cable 0"];
  EXPECT_TRUE(near(shapes["cable 2"]["to"], {-3.5, -4.5, 4})) << shapes["cable 2"];
  // The cables are attached 0.093 m above the centre of mass. The payload is shown while it is attached.
  EXPECT_NEAR(shapes["cable 0"]["from"][2].get<double>() - z, 0.093, 0.02);
  EXPECT_EQ(shapes["payload"]["visible"], true);
  browser().Evaluate("tenonReport.seek(1.8)");
  EXPECT_EQ(browser().Evaluate(
                "tenonReport.replay.runs[0].actors.find((a) => a.shape.name === 'payload').object.visible"),
            false);
}

TEST_F(ReportPageTest, ScrubbingMovesTheCursorsOfAllPlots) {
  const std::string left =
      "[...document.querySelectorAll('.plot .cursor')].map((c) => parseFloat(c.style.left))";
  const Json before = browser().Evaluate(left);
  browser().Evaluate(
      "(() => { const scrub = document.querySelector('#scrub'); scrub.value = 1.5; "
      "scrub.dispatchEvent(new Event('input')); })()");
  const Json after = browser().Evaluate(left);
  EXPECT_EQ(browser().Evaluate("tenonReport.time()"), 1.5);
  ASSERT_EQ(after.size(), 5) << "D1 has five plots";
  for (std::size_t i = 0; i < after.size(); ++i) {
    const double width =
        browser().Evaluate("document.querySelectorAll('.plot .area')[" + std::to_string(i) + "].clientWidth");
    EXPECT_NEAR(after[i].get<double>() - before[i].get<double>(), 0.75 * width, 0.1 * width);
  }
}

TEST_F(ReportPageTest, ClickInAPlotSeeksAndPlayPlays) {
  const Json chart =
      browser().Evaluate("document.querySelector('.plot .chart').getBoundingClientRect().toJSON()");
  const double width = chart["width"];
  browser().Click(chart["left"].get<double>() + 0.6 * width, chart["top"].get<double>() + 30);
  const double cursor = browser().Evaluate("parseFloat(document.querySelector('.plot .cursor').style.left)");
  EXPECT_NEAR(cursor, 0.6 * width, 2);
  EXPECT_NEAR(browser().Evaluate("tenonReport.time()").get<double>(), 1.1, 0.2);
  const double played = browser().Evaluate(R"(new Promise((resolve) => {
    tenonReport.play();
    const wait = () => tenonReport.playing() ? requestAnimationFrame(wait) : resolve(tenonReport.time());
    wait();
  }))");
  EXPECT_EQ(played, 2) << "plays to the end and stops";
}

TEST_F(ReportPageTest, WithoutWebGlPlotsAndTableAreThereAndAMessage) {
  Open({"--disable-3d-apis"});
  EXPECT_EQ(browser().Evaluate("tenonReport.webgl"), false);
  EXPECT_EQ(browser().Evaluate("document.querySelector('#no-webgl').checkVisibility()"), true);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('.plot .chart canvas').length > 0"), true);
  EXPECT_EQ(browser().Evaluate("document.querySelectorAll('#figures tr').length > 10"), true);
  browser().Evaluate("tenonReport.seek(1)");
  EXPECT_EQ(browser().Evaluate("tenonReport.time()"), 1);
  EXPECT_THAT(browser().complaints(), IsEmpty());
}

}  // namespace tenon::report_page_test
