// A page with several runs.

#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/systems/report/browser.h>

namespace tenon::tenon_report_test {

namespace fs = std::filesystem;
using test::Result, test::RunCommand, ::testing::HasSubstr;
using Json = nlohmann::json;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_REPORT) + " " + arguments);
}

struct TenonReportTest : test::AppTest {
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
  testing::RequireBrowser();
  if (IsSkipped() || HasFatalFailure()) return;
  testing::Browser browser;
  browser.Open(page);
  EXPECT_EQ(browser.Evaluate("tenonReport.ready"), true) << Json(browser.complaints());
  EXPECT_EQ(browser.Evaluate("document.querySelector('h1').textContent"), "circle, hang");
  EXPECT_EQ(browser.Evaluate("tenonReport.runs.map((run) => run.name)"), Json({"circle", "hang"}));
  EXPECT_EQ(browser.Evaluate("tenonReport.replay.runs.map((run) => run.actors.length > 5)"),
            Json({true, true}));
  // Each run keeps its figures and its signals.
  const Json summary = Json::parse(ReadText(out / "hang" / "summary.json"));
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

TEST_F(TenonReportTest, DrawsPicturesOfTwoSeconds) {
  testing::RequireBrowser();
  if (IsSkipped() || HasFatalFailure()) return;
  const std::string run = Directory("run");
  ASSERT_EQ(RunCommand(std::string(TENON_CDPR) + " D1 --controller pd --duration 2 --out " + run).exit_code,
            0);
  const std::string small = run + " --size 320x240 ";

  const fs::path video = out / "run.webm";
  ASSERT_EQ(RunApp(small + "--fps 4 --video " + video.string()).exit_code, 0);
  testing::Browser browser;
  browser.Navigate("file://" + video.string());
  EXPECT_EQ(browser.Evaluate(R"((async () => {
    const video = document.querySelector('video');
    if (video.readyState < 1) await new Promise((done) => video.onloadedmetadata = done);
    return [video.duration, video.videoWidth, video.videoHeight];
  })())"),
            Json({2, 320, 240}));

  const fs::path frames = out / "frames";
  test::AppTest::Write("frames/frame_00003.png", "of an earlier sequence");
  test::AppTest::Write("frames/frame_00002.png", "of an earlier sequence");
  for (int i = 0; i < 2; ++i) test::AppTest::Write("frames/frame_0000" + std::to_string(i) + ".png", "old");
  ASSERT_EQ(RunApp(small + "--fps 2 --from 0.5 --speed 0.5 --to 1 --frames " + frames.string()).exit_code, 0);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(frames)) {
    names.push_back(entry.path().filename());
    const std::string png = ReadText(entry.path());
    EXPECT_EQ(png.substr(1, 3), "PNG");
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\x01\x40\0\0\0\xF0", 8)) << "320 x 240";
  }
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("frame_00000.png", "frame_00001.png"));

  const fs::path plots = out / "plots";
  const Result drawn = RunApp(run + " --svg " + plots.string());
  ASSERT_EQ(drawn.exit_code, 0) << drawn.text;
  const std::string plot = ReadText(plots / "01_position_of_the_platform.svg");
  EXPECT_THAT(plot, HasSubstrs("position of the platform [m]", "time [s]", "width=\"600\""));
  EXPECT_EQ(std::distance(fs::directory_iterator(plots), {}), 5) << "D1 has five plots";
  browser.Open(plots / "01_position_of_the_platform.svg");
  EXPECT_EQ(browser.Evaluate("document.documentElement.tagName"), "svg");

  for (const char* ending : {".svg", ".png"}) {
    const fs::path frame = out / ("frame" + std::string(ending));
    ASSERT_EQ(RunApp(small + "--frame 1.5 " + frame.string()).exit_code, 0);
    EXPECT_THAT(ReadText(frame), HasSubstr(frame.extension() == ".png" ? "PNG" : ", 1.500 s</title>"));
  }

  const fs::path stopped = out / "stopped" / "run.webm";
  fs::create_directories(stopped.parent_path());
  EXPECT_EQ(RunCommand("timeout --preserve-status -s INT 2 " TENON_REPORT " " + small + "--fps 500 --video " +
                       stopped.string())
                .exit_code,
            130);
  EXPECT_TRUE(fs::is_empty(stopped.parent_path()));
  for (const std::string& beyond :
       {"--frame 2.5 x.svg", "--video x.webm --from 1 --to 3", "--video x.webm --from 1 --to 0.5"})
    EXPECT_EQ(RunApp(run + " " + beyond).exit_code, 2) << beyond;
}

TEST_F(TenonReportTest, RefusesOptionsOfPictures) {
  Fly();
  const std::string circle = Directory("circle");
  for (const auto& [arguments, place] : {std::pair{circle + " --video x.avi", std::string("--video x.avi")},
                                         {circle + " --frame 0.1 x.gif", "--frame x.gif"},
                                         {circle + " --frame x.svg", "--frame"},
                                         {circle + " --video x.webm --svg x", "--svg"},
                                         {circle + " --svg x --fps 3", "--fps"},
                                         {circle + " --video x.webm --fps 0", "--fps"},
                                         {circle + " --video x.webm --size 1280", "--size 1280"},
                                         {circle + " --svg x --size 10x2000", "--size 10x2000"},
                                         {circle + " --size 600x300", "--size"},
                                         {circle + " --svg x --out y", "--out"},
                                         {circle + " " + circle + " --svg x", "one DIR"},
                                         {out.string() + " --svg x", out.string() + "/report.html"}}) {
    const Result result = RunApp(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.text, HasSubstr(place));
  }
  EXPECT_EQ(RunApp(circle + " --video " + Directory("none") + "/x.webm").exit_code, 5);
  const Result without = RunCommand("PATH=/none " TENON_REPORT " " + circle + " --svg " + Directory("plots"));
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.text, HasSubstr("apt-get install chromium"));
  EXPECT_FALSE(fs::exists(out / "plots"));
}

TEST_F(TenonReportTest, RefusesBadUsage) {
  Fly();
  EXPECT_THAT(RunApp("--help").text, HasSubstrs("DIR", "--out", "Exit codes"));
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

}  // namespace tenon::tenon_report_test
