#include <tenon/systems/campaign/statistics.h>
#include <tenon/systems/report/campaign_report.h>
#include <tenon/systems/report/volume_report.h>
#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::campaign_report_test {

using ::testing::ElementsAre, ::testing::IsEmpty;
using Json = nlohmann::json;

/// Two axes of 3 x 2 points, 10 runs at each: the error grows with the force, a run with a force of 3 falls
/// if the friction is low.
CampaignReport Example() {
  CampaignReport report{.title = "pushes </script> & more",
                        .description = "two axes",
                        .axes = {{"force_N", {"1", "2", "3"}}, {"friction", {"0.3", "0.6"}}},
                        .drawn = {"mass_kg"},
                        .figures = {"error_max_m", "constant", "empty_N"}};
  for (std::size_t run = 0; run < 60; ++run) {
    const std::size_t force = run / 20, friction = run / 10 % 2;
    const bool survived = force < 2 || friction == 1;
    const double mass = static_cast<double>(run * 7 % 10);
    report.runs.push_back({.index = run,
                           .seed = 100 + run,
                           .at = {force, friction},
                           .drawn = {mass},
                           .figures = {static_cast<double>(force) + 0.01 * mass, 1, NAN},
                           .survived = survived,
                           .reason = survived ? "end" : "fell at " + std::to_string(run) + ".5 s, body 2"});
  }
  report.command = "again";
  report.picks = {{.index = 45, .why = "fell", .command = "again 45", .link = "run_45/report.html"}};
  return report;
}

struct CampaignReportTest : ::testing::Test {
  ~CampaignReportTest() override { std::filesystem::remove(file); }
  Json Data(const CampaignReport& report) const {
    report.Write(file);
    return testing::DataOf(file);
  }
  const std::filesystem::path file = test::TemporaryPath("tenon_campaign_report.html");
};

TEST_F(CampaignReportTest, CountsSurvivalAtEachPoint) {
  const Json data = Data(Example());
  EXPECT_EQ(data["survival"]["survived"], 50);
  EXPECT_EQ(data["survival"]["count"], 60);
  EXPECT_EQ(data["survival"]["low"], WilsonInterval(50, 60, 0.95).low);
  ASSERT_EQ(data["points"].size(), 6U);
  EXPECT_EQ(data["points"][4]["at"], Json({2, 0}));
  EXPECT_EQ(data["points"][4]["survived"], 0);
  EXPECT_EQ(data["points"][5]["survived"], 10);
  EXPECT_NEAR(data["points"][2]["medians"][0].get<double>(), 1.045, 1e-12);
  EXPECT_TRUE(data["points"][2]["medians"][2].is_null());
  EXPECT_EQ(data["points"][2]["missing"][0], 0);
  EXPECT_EQ(data["points"][2]["missing"][2], data["points"][2]["count"]);
}

TEST_F(CampaignReportTest, FindsWhatMatters) {
  const Json rows = Data(Example())["correlations"];
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["name"], "force_N");
  EXPECT_GT(rows[0]["values"][0].get<double>(), 0.9);
  EXPECT_TRUE(rows[0]["values"][1].is_null());                // a figure that never changes
  EXPECT_LT(rows[0]["values"][3].get<double>(), -0.4);        // survival
  EXPECT_NEAR(rows[2]["values"][3].get<double>(), 0, 1e-12);  // the mass has nothing to do with it
}

TEST_F(CampaignReportTest, CausesThatDifferInNumbersAreOne) {
  CampaignReport report = Example();
  report.runs[0].survived = false;
  report.runs[0].reason = "refused: friction = 0";
  const auto causes = report.Causes();
  ASSERT_EQ(causes.size(), 2U);
  EXPECT_EQ(causes[0].text, "fell at … s, body …");
  EXPECT_EQ(causes[0].count, 10U);
  EXPECT_THAT(causes[0].first, ElementsAre(40, 41, 42, 43, 44));
  EXPECT_EQ(causes[1].text, "refused: friction = 0");
}

TEST_F(CampaignReportTest, HistogramsHoldEveryRun) {
  const Json histogram = Data(Example())["histograms"][0];
  int survived = 0, failed = 0;
  for (const auto& count : histogram["survived"]) survived += count.get<int>();
  for (const auto& count : histogram["failed"]) failed += count.get<int>();
  EXPECT_EQ(survived, 50);
  EXPECT_EQ(failed, 10);
  EXPECT_TRUE(Data(Example())["histograms"][2].is_null());
}

TEST_F(CampaignReportTest, RefusesRunsThatDoNotMatchItsNames) {
  const auto refused = [this](auto change, const std::string& part) {
    CampaignReport report = Example();
    change(report.runs[7]);
    return Throws<ParameterError>([&] { report.Write(file); }, "run 7", part);
  };
  using Run = CampaignReport::Run;
  EXPECT_TRUE(refused([](Run& run) { run.figures.pop_back(); }, "2 figures"));
  EXPECT_TRUE(refused([](Run& run) { run.drawn.push_back(1); }, "2 drawn"));
  EXPECT_TRUE(refused([](Run& run) { run.at.clear(); }, "0 labels"));
  EXPECT_TRUE(refused([](Run& run) { run.at[1] = 2; }, "'friction'"));
}

using CampaignPageTest = testing::BrowserTest;

TEST_F(CampaignPageTest, ShowsItAll) {
  const std::filesystem::path file = test::TemporaryPath("tenon_campaign_page.html");
  CampaignReport many = Example();
  for (std::size_t run = 60; run < 30'000; ++run) {
    many.runs.push_back(many.runs[run % 60]);
    many.runs.back().index = run;
  }
  CampaignReport one{.title = "one point"};
  one.runs.push_back({.survived = true});
  CampaignReport none{
      .title = "no run at all", .axes = {{"x", {"a", "b"}}, {"y", {"c", "d"}}}, .figures = {"error_m"}};
  CampaignReport failed{.title = "nobody survived", .axes = {{"x", {"a"}}}, .figures = {"error_m"}};
  failed.runs.push_back({.at = {0}, .figures = {NAN}, .reason = "fell"});
  for (const CampaignReport& report : {Example(), many, one, none, failed}) {
    report.Write(file);
    browser.Open(file);
    EXPECT_EQ(Js("window.tenonCampaign.ready"), true) << report.title;
    EXPECT_EQ(Js("document.querySelector('h1').textContent"), report.title);
    EXPECT_THAT(browser.complaints(), IsEmpty()) << report.title;
  }
  Example().Write(file);
  browser.Open(file);
  EXPECT_EQ(Js("document.querySelectorAll('#map rect').length"), 6);
  EXPECT_EQ(Js("document.querySelectorAll('#survival circle').length"), 6);
  EXPECT_EQ(Js("document.querySelector('#picks a').getAttribute('href')"), "run_45/report.html");
  EXPECT_EQ(Js("document.querySelectorAll('#lines path').length"), 60);
  // Another colour: the median of the error.
  Js("(() => { const s = document.querySelectorAll('#map select')[2]; s.value = 1; s.dispatchEvent(new "
     "Event('change')); })()");
  EXPECT_EQ(Js("document.querySelector('#map rect title').textContent"),
            "friction = 0.3, force_N = 1: 0.045");
  EXPECT_THAT(testing::LayoutFaults(browser), IsEmpty());
  std::filesystem::remove(file);
}

TEST_F(CampaignPageTest, DrawsAnyTwoColumns) {
  const std::filesystem::path file = test::TemporaryPath("tenon_campaign_scatter.html");
  Example().Write(file);
  browser.Open(file);
  Js(R"(window.choose = (select, text) => {
    const list = document.querySelectorAll('#scatter select')[select];
    list.value = [...list.options].findIndex((option) => option.textContent === text);
    list.dispatchEvent(new Event('change'));
  })");
  Js("window.points = () => [...document.querySelectorAll('#scatter path')].filter((p) => p.onclick)");
  EXPECT_EQ(Js("[points().length, points().filter((p) => p.classList.contains('bad')).length]"),
            Json({60, 10}));
  EXPECT_EQ(Js("[...document.querySelectorAll('#scatter select')[0].options].map((o) => o.textContent)"),
            Json({"force [N]", "friction", "mass [kg]", "error max [m]"}));
  EXPECT_EQ(Js("points().at(-1).querySelector('title').textContent"), "run 49, seed 149, failed");
  Js("points().at(-1).onclick()");
  EXPECT_EQ(Js("document.querySelector('#scatter .repeat code').textContent"), "again --replay 49");
  Js("(choose(0, 'friction'), choose(1, 'mass [kg]'), choose(2, 'force [N]'))");
  EXPECT_EQ(Js("new Set(points().map((p) => p.getAttribute('d').split(/[M,]/)[1])).size"), 2) << "two places";
  EXPECT_EQ(Js("new Set(points().map((p) => p.getAttribute('stroke'))).size"), 3)
      << "a colour for each force";
  const Json pictures = Js(R"(Object.fromEntries(tenonCampaign.pictures().map(([title, text]) => {
    const page = new DOMParser().parseFromString(text, 'application/xml');
    return [title, [page.documentElement.tagName, page.querySelectorAll('[class]').length, [...page.querySelectorAll('text')].map((t) => t.textContent).join('|')]];
  })))");
  for (const auto& [title, picture] : pictures.items()) {
    EXPECT_EQ(picture[0], "svg") << title;
    EXPECT_EQ(picture[1], 0) << title << " does not need the style sheet";
  }
  EXPECT_THAT(pictures["Any two columns"][2].get<std::string>(),
              HasSubstrs("|friction|", "mass [kg]", "force [N]: 1"));
  EXPECT_TRUE(pictures.contains("Map") && pictures.contains("Survival")) << pictures;
  EXPECT_THAT(browser.complaints(), IsEmpty());
  std::filesystem::remove(file);
}

using ::testing::Each, ::testing::IsEmpty, ::testing::StartsWith;
using State = VolumeReport::State;

/// A box of 4 x 3 x 2 cells: a block of 2 x 2 x 2 cells holds, one beside it is undecided, the rest fails.
VolumeReport Volume() {
  VolumeReport::Map map{.title = "places",
                        .coordinates = {"x_m", "y_m", "z_m"},
                        .low = {-2, 0, 1},
                        .high = {2, 3, 2},
                        .cells = {4, 3, 2},
                        .quantities = {"margin_N", "stiffness_N_per_m"},
                        .parts = {{{0, 0, 0}, {2, 2, 2}, State::kHolds, {5, 100}},
                                  {{2, 0, 0}, {1, 1, 1}, State::kUndecided, {1, test::kNan}},
                                  {{2, 0, 1}, {1, 1, 1}, State::kFails, {-1, test::kNan}},
                                  {{3, 0, 0}, {1, 1, 2}, State::kFails, {-2, test::kNan}},
                                  {{2, 1, 0}, {2, 1, 2}, State::kFails, {-2, test::kNan}},
                                  {{0, 2, 0}, {4, 1, 2}, State::kFails, {-3, test::kNan}}},
                        .shapes = {Shape::Box(ShapeRole::kBody, "body", {0.5, 0.5, 0.5})}};
  VolumeReport::Map other = map;
  other.title = "turns";
  other.shapes.clear();
  return {.title = "box </script> & more",
          .description = "four by three by two",
          .figures = {{"volume_m3", 8.0}, {"nothing_N", std::nullopt}},
          .maps = {map, other}};
}

struct VolumeReportTest : testing::BrowserTest {
  ~VolumeReportTest() override { std::filesystem::remove(file); }
  const std::filesystem::path file = test::TemporaryPath("tenon_volume_report.html");
};

TEST_F(VolumeReportTest, PageShowsCellsSlicesAndTheirSurface) {
  Volume().Write(file);
  browser.Open(file);
  ASSERT_EQ(Js("!!window.tenonVolume && tenonVolume.ready"), true)
      << nlohmann::json(browser.complaints()).dump();
  EXPECT_EQ(Js("document.querySelector('h1').textContent"), "box </script> & more");
  EXPECT_EQ(Js("[...document.querySelectorAll('#figures td')].map((cell) => cell.textContent)"),
            nlohmann::json({"8", "m³", "–", "N"}));
  EXPECT_EQ(Js("[tenonVolume.state(1, 1, 1), tenonVolume.state(2, 0, 0), tenonVolume.state(2, 0, 1)]"),
            nlohmann::json({2, 1, 0}));
  EXPECT_EQ(Js("document.querySelectorAll('#slices canvas').length"), 3);

  // The colour of a cell in the slice across z: what holds is coloured, what fails is white.
  const nlohmann::json colours = Js(R"((() => {
    const canvas = document.querySelector('#slices canvas'), width = parseFloat(canvas.style.width);
    const ratio = canvas.width / width, scale = Math.min((width - 56) / 4, 100);
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return [[3.5, 0.5], [0.5, 2.5]].map(([x, y]) => {
      const at = 4 * (Math.floor((6 + scale * y) * ratio) * canvas.width + Math.floor((46 + scale * x) * ratio));
      return [...pixels.data.slice(at, at + 3)].join();
    });
  })())");
  EXPECT_EQ(colours[0], "255,255,255");
  EXPECT_NE(colours[1], "255,255,255");

  // A block of 2 x 2 x 2 cells has 24 faces of cells.
  if (Js("tenonVolume.webgl") == true) {
    EXPECT_EQ(Js("tenonVolume.faces"), 24);
    EXPECT_EQ(Js("tenonVolume.replay.runs[0].group.children.filter((c) => c.isMesh).length"), 1);
  }
  Js("tenonVolume.colour(1)");
  Js("tenonVolume.show(1)");
  EXPECT_EQ(
      Js("[...document.querySelectorAll('#choosers select')].map((s) => s.selectedOptions[0].textContent)"),
      nlohmann::json({"turns", "margin [N]"}));
  EXPECT_THAT(browser.complaints(), IsEmpty());
  EXPECT_THAT(browser.requests(), Each(StartsWith("file:")));
}

TEST_F(VolumeReportTest, RefusesPartsWithOtherQuantities) {
  VolumeReport report = Volume();
  report.maps[0].parts[3].values.pop_back();
  EXPECT_TRUE(Throws<ParameterError>([&] { report.Write(file); }, "'places'"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace tenon::campaign_report_test
