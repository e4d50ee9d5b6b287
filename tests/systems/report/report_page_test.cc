// The page of a report: use by mouse and keys, windows of several sizes, dark colours, printing.

#include <tenon/systems/report/report.h>
#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/temporary_path.h>

#include <numbers>

namespace tenon::report_page_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::Each, ::testing::HasSubstr, ::testing::IsEmpty, ::testing::StartsWith;

/// A run with every kind of content, and a browser that shows it.
struct RunPageTest : testing::BrowserTest {
  ~RunPageTest() override { fs::remove(file); }
  void TearDown() override { EXPECT_THAT(browser.complaints(), IsEmpty()); }

  static Report Run(bool drawn, double load) {
    DiagramBuilder builder;
    auto& tension = builder.AddFunction({"tension", "N"}, Uses(builder.time), [load](double t) {
      return Vec<24>(Vec<24>::LinSpaced(100, 330) * (1 + load * t));
    });
    auto& truth =
        builder.AddFunction({"truth", "N"}, Uses(builder.time), [](double t) { return std::sin(6 * t); });
    auto& measured = builder.AddFunction({"measured", "N"}, Uses(builder.time), [](double t) {
      return std::sin(6 * t) + 0.3 * std::sin(1.2e4 * t);
    });
    auto& angle = builder.AddFunction({"angle", "rad"}, Uses(builder.time), [](double t) { return t; });
    auto& error = builder.AddFunction({"error", "m"}, Uses(builder.time), [](double t) { return 1e-3 * t; });
    const TriangleMesh roof{{{0, 0, 0.1F}, {0.1F, 0, 0}, {0, 0.1F, 0}, {-0.1F, -0.1F, 0}},
                            {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}},
                            {{255, 0, 51, 255}, {255, 0, 51, 255}, {255, 0, 51, 255}, {}}};
    Geometry shapes{Shape::Box(ShapeRole::kBody, "box", {0.3, 0.2, 0.1}),
                    Shape::Trace(ShapeRole::kReference, "path"),
                    Shape::Mesh(ShapeRole::kLoad, "roof", std::make_shared<const TriangleMesh>(roof))};
    auto& look = builder.AddFunction({"look"}, Uses(builder.time), [shapes](double t) {
      Geometry now = shapes;
      for (Shape& shape : now) shape.p_W = {t, 0, 0.1};
      return now;
    });
    Report report({.title = "workshop",
                   .plots = {{"cables", {"tension.output"}, {}, "forces"},
                             {"force", {"truth.output"}, {"measured.output"}, "forces"},
                             {"angle", {"angle.output"}, {}},
                             {"error", {"error.output"}, {}}},
                   .limits = {{"tension.output", {.low = 0, .high = 250}},
                              {"angle.output", {.high = 0.5}},
                              {"error.output", {.high = 7}}}});
    Simulator simulator(builder.Build());
    report.Log(
        simulator, {&tension, &truth, &measured, &angle, &error},
        drawn ? std::vector<const OutputPort<Geometry>*>{&look} : std::vector<const OutputPort<Geometry>*>{});
    report.Conclude(simulator.AdvanceTo(1));
    report.AddFigure("com_error_max_m", 0.0123);
    report.AddFigure("tilt_max_rad", 0.5);
    report.AddFigure("tension_max_N", 330 * (1 + load), {.low = 0, .high = 250});
    for (const auto& [leg, value] : {std::pair{"front_left", 0.001},
                                     {"front_right", 0.002},
                                     {"rear_left", 0.003},
                                     {"rear_right", 0.004}})
      report.AddFigure(std::string("foot_error_max_m.") + leg, value);
    report.AddFigure("force_mean_N.x", 2.5);
    report.AddFigure("force_mean_N.y", -0.0001);
    report.AddFigure("robot", "/a/path/that/is/longer/than/a/column/and/has/no/blank/my_robot.yaml");
    report.AddEvent(0.25, "push");
    report.AddEvent(0.75, "pull");
    return report;
  }

  void Open(const Report& report) {
    report.Write(file);
    browser.Open(file);
    ASSERT_EQ(Js("!!window.tenonReport && tenonReport.ready"), true) << Json(browser.complaints());
    Js("window.plot = (title) => tenonReport.plots.plots.find((p) => p.spec.title === title)");
    Js("window.press = (node, text) => [...node.querySelectorAll('button')].find((b) => "
       "b.textContent.includes(text)).click()");
  }
  /// Evaluates an expression after pending drawing is done.
  Json Settle(const std::string& expression) {
    Js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
    return Js(expression);
  }

  const fs::path file = test::TemporaryPath("a%20b #1?\x01.html");  // any name opens
};

// A path is drawn with equal scales, has a dot at the time that is shown, and is saved as picture and as
// table.
TEST_F(RunPageTest, APathIsDrawnOverTheFirstElement) {
  DiagramBuilder builder;
  auto& p = builder.AddFunction({"p", "m", "x,y"}, Uses(builder.time),
                                [](double t) { return Vec<2>(2 * std::cos(t), std::sin(t)); });
  const auto diagram = builder.Build();
  Report report({.title = "ellipse", .plots = {{"orbit", {"xy:p.output"}}, {"radius", {"norm:p.output"}}}});
  Simulator simulator(*diagram);
  report.Log(simulator, {&p});
  report.Conclude(simulator.AdvanceTo(2 * std::numbers::pi));
  Open(report);
  const std::string box = "plot('orbit').chart.querySelector('path:not(.axis)').getBBox()";
  const double width = Js(box + ".width"), height = Js(box + ".height");
  EXPECT_NEAR(width / height, 2, 0.02);
  EXPECT_GT(height, 50);
  const auto dot = [&](const char* name) {
    return std::stod(
        Js("plot('orbit').chart.querySelector('circle').getAttribute('" + std::string(name) + "')")
            .get<std::string>());
  };
  Js("tenonReport.seek(0)");
  const double right = dot("cx"), middle = dot("cy");
  Js("tenonReport.seek(Math.PI / 2)");
  EXPECT_NEAR(right - dot("cx"), width / 2, 1);
  EXPECT_NEAR(middle - dot("cy"), height / 2, 1);
  EXPECT_THAT(Js("plot('orbit').csv()").get<std::string>(),
              StartsWith("time [s],p.output.x [m],p.output.y [m]\n0,2,0\n"));
  EXPECT_EQ(Js("tenonReport.pictures(600, 300).map(([name, text]) => [name, text.includes('<path')])"),
            Json::array({Json::array({"orbit", true}), Json::array({"radius", true})}));
  EXPECT_EQ(Js("plot('radius').series[0].label"), "|output|");
}

TEST_F(RunPageTest, TheReplayStaysInViewInWindowsOfAnySize) {
  Open(Run(true, 0));
  for (const auto& [width, height] : {std::pair{480, 900}, {1920, 700}, {1280, 800}}) {
    browser.Resize(width, height);
    Js("scrollTo(0, 0)");
    EXPECT_LE(Settle("document.documentElement.scrollWidth").get<int>(), width) << "no scrolling sideways";
    EXPECT_EQ(Settle("(({scrollWidth, clientWidth}) => scrollWidth - "
                     "clientWidth)(document.querySelector('#figures > div'))"),
              0)
        << "nor of the figures";
    const std::string inside =
        "(() => { const a = document.querySelector('#stage').getBoundingClientRect(), b = "
        "document.querySelector('#transport').getBoundingClientRect(); return a.height > 150 && a.top >= 0 "
        "&& b.bottom <= innerHeight; })()";
    EXPECT_EQ(Settle(inside), true) << width << " at first";
    EXPECT_GT(Js("(scrollTo(0, 1e6), scrollY)").get<double>(), 100) << "there is something to scroll";
    EXPECT_EQ(Settle(inside), true) << width << " at the end of the plots";
  }
  const std::string share = "document.querySelector('#side').clientWidth / innerWidth";
  EXPECT_LT(Settle(share).get<double>(), 0.6);
  browser.Press("h");
  EXPECT_GT(Settle(share).get<double>(), 0.9) << "full width without the replay";
  browser.Press("h");
  EXPECT_LT(Settle(share).get<double>(), 0.6);
  Js("document.querySelector('#splitter').focus()");
  browser.Press("ArrowLeft");
  EXPECT_EQ(Js("document.querySelector('#splitter').ariaValueNow"), "51");
  EXPECT_EQ(Js("tenonReport.time()"), 0) << "the arrow was the splitter's";

  Open(Run(false, 0));
  EXPECT_GT(Settle(share).get<double>(), 0.9) << "nothing is drawn";
  EXPECT_EQ(Js("document.querySelector('#stage').checkVisibility()"), false);
  EXPECT_EQ(Js("document.querySelector('#transport').checkVisibility()"), true);
  EXPECT_THAT(browser.requests(), Each(StartsWith("file:")));
}

TEST_F(RunPageTest, PlotsFoldGroupGrowAndTakeSignals) {
  Open(Run(false, 0));
  EXPECT_EQ(Js("[...document.querySelectorAll('.group')].map((g) => [g.dataset.group, "
               "g.querySelectorAll('.plot').length])"),
            Json::parse(R"([["forces", 2], ["", 2]])"));
  Js("press(document.querySelector('.group h2'), 'forces')");
  EXPECT_EQ(Js("[plot('cables').box.checkVisibility(), plot('angle').box.checkVisibility()]"),
            Json({false, true}));
  Js("press(document.querySelector('.group h2'), 'forces')");
  EXPECT_EQ(Js("plot('cables').chart.clientWidth > 100 && plot('cables').graph.getArea().w > 100"), true);

  Js("press(plot('angle').box, 'angle')");
  EXPECT_EQ(Js("[plot('angle').area.checkVisibility(), plot('angle').fold.ariaExpanded]"),
            Json({false, "false"}));
  Js("press(plot('angle').box, 'angle')");
  EXPECT_EQ(Js("plot('angle').area.checkVisibility()"), true);
  Js("document.querySelector('#fold-all').click()");
  EXPECT_EQ(Js("[...document.querySelectorAll('.area')].some((a) => a.checkVisibility())"), false);
  Js("document.querySelector('#fold-all').click()");

  const double height = Js("plot('error').area.clientHeight");
  Js("plot('error').box.querySelector('.resize').focus()");
  browser.Press("ArrowDown");
  EXPECT_EQ(Settle("[plot('error').area.clientHeight, plot('error').graph.size().height]"),
            Json({height + 20, height + 20}));

  // The user adds any logged signal to a new plot or to an existing one.
  Js("document.body.focus()");
  browser.Press("a");
  EXPECT_EQ(Js("[...document.querySelectorAll('#picker details')].map((d) => "
               "d.querySelector('input').dataset.name)"),
            Json({"tension.output", "truth", "measured", "angle", "error"}));
  Js("(() => { const s = document.querySelector('#picker input[type=search]'); s.value = 'sion output 7'; "
     "s.dispatchEvent(new Event('input')); })()");
  EXPECT_EQ(Js("[...document.querySelectorAll('#picker details')].filter((d) => !d.hidden).length"), 1);
  Js("document.querySelector('#picker input[data-name=\"tension.output.7\"]').click()");
  Js("document.querySelector('#picker input[data-name=\"angle\"]').click()");
  Js("press(document.querySelector('#picker'), 'plot')");
  EXPECT_EQ(Js("plot('tension.output.7, angle').series.map((s) => s.signal.name)"),
            Json({"tension.output.7", "angle.output"}));
  EXPECT_EQ(Js("plot('tension.output.7, angle').box.closest('.group').dataset.group"), "chosen signals");
  Js("press(plot('error').box, '+')");
  Js("document.querySelector('#picker input[data-name=\"truth\"]').click()");
  Js("press(document.querySelector('#picker'), 'plot')");
  EXPECT_EQ(Js("plot('error').graph.getLabels().length"), 3) << "time, error, truth";
  Js("[...plot('error').box.querySelectorAll('.readout button')].at(-1).click()");
  EXPECT_EQ(Js("plot('error').graph.getLabels().length"), 2) << "switched off";
  Js("press(plot('tension.output.7, angle').box, '✕')");
  EXPECT_EQ(Js("document.querySelectorAll('.group').length"), 2);
}

TEST_F(RunPageTest, LimitsEnvelopesNoiseAndUnits) {
  Open(Run(false, 0));
  // 24 cables begin as an envelope: one curve with a band.
  const std::string columns = "[plot('cables').envelope, plot('cables').graph.numColumns()]";
  EXPECT_EQ(Js(columns), Json({true, 2}));
  EXPECT_EQ(Js("plot('cables').graph.rawData_[0][1].map(Math.round)"), Json({100, 215, 330}));
  EXPECT_THAT(Js("plot('cables').readout.textContent").get<std::string>(),
              HasSubstr("100 (0) … 330 (23), 24 signals"));
  Js("press(plot('cables').box, 'envelope')");
  EXPECT_EQ(Js(columns), Json({false, 25}));

  EXPECT_EQ(Js("plot('cables').limits().map((l) => l.text)"), Json({"limit 0 N", "limit 250 N"}));
  // The number of pixels with the colour of limits in the row of a value.
  const std::string red = R"((title, value) => {
    const canvas = plot(title).chart.querySelector('canvas'), graph = plot(title).graph, scale = canvas.width / canvas.clientWidth;
    const copy = Object.assign(document.createElement('canvas'), {width: canvas.width, height: canvas.height}).getContext('2d');
    copy.drawImage(canvas, 0, 0);
    const y = Math.round(graph.toDomYCoord(value) * scale), row = copy.getImageData(0, y - 2, canvas.width, 5).data;
    let count = 0;
    for (let i = 0; i < row.length; i += 4) count += row[i + 3] > 100 && row[i] > 150 && row[i + 1] < 100 && row[i + 2] < 90;
    return count;
  })";
  Js("window.red = " + red);
  EXPECT_GT(Js("red('angle', 0.5 * 180 / Math.PI)").get<int>(), 100) << "a dashed line";
  EXPECT_EQ(Js("red('angle', 0.3 * 180 / Math.PI)"), 0);

  // Angles in degrees, lengths in mm; the numbers that are saved stay in SI units.
  EXPECT_EQ(Js("['angle', 'error', 'force'].map((t) => plot(t).unit.textContent)"),
            Json({"[°]", "[mm]", "[N]"}));
  EXPECT_NEAR(Js("(tenonReport.seek(1), parseFloat(plot('angle').series[0].text.textContent))").get<double>(),
              57.3, 0.05);
  EXPECT_THAT(Js("plot('angle').csv()").get<std::string>(),
              StartsWith("time [s],angle.output [rad]\n0,0\n0.005,0.005\n"));

  // The true curve is drawn last, the noisy one thin.
  EXPECT_EQ(Js("plot('force').shown().map((s) => s.signal.name)"), Json({"measured.output", "truth.output"}));
  EXPECT_EQ(Js("['0: output ref', '1: output'].map((n) => plot('force').graph.getOption('strokeWidth', n))"),
            Json({0.8, 1.6}));

  const Json figures =
      Js("Object.fromEntries([...document.querySelectorAll('#figures tr')].map((r) => [r.cells[0].title, "
         "[r.cells[0].textContent, r.cells[1].textContent, r.cells[1].title, r.cells[2].textContent]]))");
  EXPECT_EQ(figures["com_error_max_m"], Json({"com error max", "12.3", "0.0123 m", "mm"}));
  EXPECT_EQ(figures["tilt_max_rad"], Json({"tilt max", "28.65", "0.5 rad", "°"}));
  EXPECT_EQ(figures["tension_max_N"], Json({"tension max 0 … 250", "330", "330 N beyond its limit", "N"}));
  // A figure beyond a limit does not look like the limit.
  EXPECT_EQ(Js("[[5.00001, [5]], [5, [5.00001]], [5, [5]], [7.12345, [5]], [0, [1e-20]]].map((of) => "
               "formatBeside(...of))"),
            Json({"5.00001", "5", "5", "7.123", "0"}));
  EXPECT_EQ(figures["foot_error_max_m"], Json({"foot error max", "1 … 4", "", "mm"}));
  EXPECT_EQ(figures["foot_error_max_m.rear_left"], Json({"rear left", "3", "0.003 m", "mm"}));
  EXPECT_EQ(figures["force_mean_N"], Json({"force mean", "2.500, -0.000", "", "N"}));
  const std::string inner = "document.querySelector('#figures tr.inner').checkVisibility()";
  EXPECT_EQ(Js(inner), false);
  Js("press(document.querySelector('#figures'), 'foot error')");
  EXPECT_EQ(Js(inner), true);
  EXPECT_EQ(Js("['noise_bandwidth_Hz', 'gains_per_s', 'stiffness_N_s_per_m', 'x_m_per_s2', "
               "'loop.delay_s.mean', 'case_on_front'].map((k) => parseKey(k).unit)"),
            Json({"Hz", "1/s", "N s/m", "m/s²", "s", ""}));
}

TEST_F(RunPageTest, LightDarkPaperAndFiles) {
  browser.Prefer("dark");
  Open(Run(true, 0));
  const std::string grounds =
      "[document.documentElement.dataset.theme, getComputedStyle(document.body).backgroundColor]";
  EXPECT_EQ(Js(grounds), Json({"dark", "rgb(18, 22, 28)"}));
  const std::string stage = "tenonReport.replay.renderer.getClearColor().getHexString()";
  EXPECT_EQ(Js(stage), "171c24");
  EXPECT_EQ(Js("tenonReport.replay.runs[0].actors[2].object.children[0].geometry.index.count"), 9)
      << "the mesh";
  EXPECT_EQ(Js("[...tenonReport.replay.runs[0].actors[2].object.children[0].geometry.attributes.color.array]."
               "map((part) => Math.round(255 * part))"),
            Json({255, 0, 51, 255, 0, 51, 255, 0, 51, 0xb5, 0x65, 0x1d}))
      << "three corners have a colour of their own, one that of the role";
  Js("dispatchEvent(new Event('beforeprint'))");
  EXPECT_EQ(Js(grounds)[0], "light") << "on paper";
  Js("dispatchEvent(new Event('afterprint'))");
  EXPECT_EQ(Js(grounds)[0], "dark");
  browser.Press("t");
  EXPECT_EQ(Js(grounds), Json({"light", "rgb(246, 247, 249)"}));
  EXPECT_EQ(Js(stage), "fbfcfd");
  EXPECT_EQ(Js("plot('angle').graph.getOption('gridLineColor')"), "#e8ebef");

  // The files that the buttons save.
  Js("window.saved = []; HTMLAnchorElement.prototype.click = function() { saved.push(this.download); }");
  EXPECT_EQ(Js(R"((async () => {
              press(plot('force').box, 'CSV');
              press(plot('force').box, 'SVG');
              press(plot('force').box, 'PNG');
              while (saved.length < 3) await new Promise((done) => setTimeout(done, 5));
              document.querySelector('#speed').value = 10;
              for (const choice of [1, 2, 3]) {
                const menu = document.querySelector('#save');
                menu.selectedIndex = choice;
                menu.onchange();
                while (saved.length < 3 + choice) await new Promise((done) => setTimeout(done, 5));
              }
              return saved;
            })())"),
            Json({"force.csv", "force.svg", "force.png", "workshop.svg", "workshop.png", "workshop.webm"}));
}

TEST_F(RunPageTest, PlotsAsVectorPictures) {
  browser.Prefer("dark");
  Open(Run(false, 0));
  // The parts of a picture, read by the browser's parser of XML.
  Js(R"(window.partsOf = (text) => {
    const page = new DOMParser().parseFromString(text, 'application/xml'), all = (selector) => [...page.querySelectorAll(selector)];
    return {root: page.documentElement.tagName, texts: all('text').map((t) => t.textContent), classes: all('[class]').length,
            curves: all('g > path').map((p) => [p.getAttribute('stroke'), p.getAttribute('stroke-dasharray'), p.getAttribute('d').length]),
            ground: all('rect')[0].getAttribute('fill'), text: all('text').at(-1).getAttribute('fill')};
  })");
  const auto parts = [&](const std::string& title) {
    return Js("partsOf(svgText(pictureOf(plot('" + title + "'), 600, 300)))");
  };
  Json force = parts("force");
  EXPECT_EQ(force["root"], "svg");
  EXPECT_THAT(force["texts"].dump(), HasSubstrs("\"time [s]\"", "\"force [N]\"", "\"output\"",
                                                "\"output ref\"", "\"push\"", "\"-0.5\""));
  EXPECT_EQ(force["ground"], "#fff");
  EXPECT_EQ(force["classes"], 0) << "the file does not need the style sheet";
  ASSERT_EQ(force["curves"].size(), 2U);
  EXPECT_EQ(force["curves"][0][0], "#1f77b4") << "the colours are those of the light theme";
  EXPECT_EQ(force["curves"][0][1], "5 4") << "a reference is dashed";
  EXPECT_EQ(force["curves"][1][1], "none");
  EXPECT_EQ(Js("document.documentElement.dataset.theme"), "dark") << "the page stays as it is";
  EXPECT_THAT(parts("angle")["texts"].dump(), HasSubstrs("limit 28.65 °", "angle [°]"));
  EXPECT_THAT(parts("cables")["texts"].dump(), HasSubstr("lowest, mean and highest"));
  EXPECT_EQ(parts("cables")["curves"].size(), 2U) << "the band and the mean";

  Js("plot('force').graph.updateOptions({dateWindow: [0.2, 0.41]})");
  const Json zoomed = parts("force");
  EXPECT_THAT(zoomed["texts"].dump(), HasSubstr("\"0.22\""));
  EXPECT_LT(zoomed["curves"][1][2].get<int>(), force["curves"][1][2].get<int>() / 2);
  EXPECT_EQ(Js("tenonReport.pictures(600, 300).map((p) => p[0])"),
            Json({"cables", "force", "angle", "error"}));

  EXPECT_EQ(Js("[[0, 1, 5], [-0.3, 0.31, 3], [2e6, 4e6, 2], [1, 1.0000001, 1]].map(([low, high, n]) => "
               "ticksOf([low, high], n).map((t) => t.text).join())"),
            Json({"0,0.2,0.4,0.6,0.8,1", "-0.2,0,0.2", "2e+6,3e+6,4e+6", "1e+0,1.0000001e+0"}));
  EXPECT_EQ(Js("pathOf([[0, 1], [1, 2], [2, NaN], [3, 1 / 3]])"), "M0,1L1,2M3,0.33");
  EXPECT_EQ(Js("outlineOf([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2], [1, 0]].map(([x, y]) => ({x, "
               "y}))).map(({x, y}) => [x, y])"),
            Json::parse("[[0, 0], [2, 0], [2, 2], [0, 2]]"));
}

TEST_F(RunPageTest, ReplayAsPictureAndVideo) {
  Open(Run(true, 0));
  const Json drawn = Js(R"((() => {
    const text = tenonReport.picture(0.5), page = new DOMParser().parseFromString(text, 'application/xml');
    const {replay} = tenonReport, fill = (p) => p.getAttribute('fill');
    const faces = [...page.querySelectorAll('polygon[stroke-width="0.7"]')].map((p) => p.getAttribute('points').split(' ').map((c) => c.split(',').map(Number)));
    const at = new THREE.Vector3(0.5, 0, 0.1).project(replay.camera), corners = faces.flat(), middle = (k) => (Math.min(...corners.map((c) => c[k])) + Math.max(...corners.map((c) => c[k]))) / 2;
    return {title: page.querySelector('title').textContent, faces: faces.length, triangles: page.querySelectorAll('polygon[stroke-width="0.4"]').length,
            off: [(at.x + 1) / 2 * replay.size.width - middle(0), (1 - at.y) / 2 * replay.size.height - middle(1)].map((d) => Math.abs(d) / replay.size.width),
            notes: [...page.querySelectorAll('text')].map((t) => t.textContent), dashed: page.querySelectorAll('polyline[stroke-dasharray="5 4"]').length,
            shadows: page.querySelectorAll('g[opacity="0.14"] polygon').length};
  })())");
  EXPECT_EQ(drawn["title"], "workshop, 0.500 s");
  EXPECT_EQ(drawn["faces"], 3) << "a box shows three faces";
  EXPECT_EQ(drawn["triangles"], 3) << "the mesh";
  EXPECT_LT(drawn["off"][0].get<double>(), 0.02) << "the box is where the camera sees it";
  EXPECT_LT(drawn["off"][1].get<double>(), 0.02);
  EXPECT_EQ(drawn["dashed"], 1) << "the path";
  EXPECT_EQ(drawn["shadows"], 2);
  EXPECT_THAT(drawn["notes"].dump(), HasSubstrs("bodies", "0.50 s", "grid "));

  const std::string size =
      "[tenonReport.replay.renderer.domElement.width, tenonReport.replay.camera.aspect.toFixed(3)]";
  const Json before = Js(size);
  const Json film = Js(R"((async () => {
    const movie = tenonReport.movie({width: 161, height: 120, from: 0.2, to: 0.8, speed: 0.5, fps: 5});
    for (let i = 0; i < movie.count; ++i) await movie.add(i);
    const video = document.createElement('video');
    video.src = URL.createObjectURL(await movie.file());
    await new Promise((done, fail) => { video.oncanplaythrough = done; video.onerror = () => fail(new Error(video.error.message)); });
    video.currentTime = 1.1;
    await new Promise((done) => video.onseeked = done);
    const canvas = Object.assign(document.createElement('canvas'), {width: 160, height: 120}), context = canvas.getContext('2d');
    movie.draw(movie.timeOf(5));
    const own = movie.context.getImageData(0, 0, 160, 120).data;
    let off = 256;
    for (let tries = 0; tries < 100 && off >= 8; ++tries) {  // the frame may be decoded after `seeked`
      await new Promise((done) => setTimeout(done, 20));
      context.drawImage(video, 0, 0);
      const shown = context.getImageData(0, 0, 160, 120).data;
      off = 0;
      for (let i = 0; i < own.length; ++i) off += Math.abs(own[i] - shown[i]) / own.length;
    }
    movie.end();
    return {times: Array.from({length: movie.count}, (_, i) => Number(movie.timeOf(i).toFixed(6))), size: [video.videoWidth, video.videoHeight], duration: video.duration, off, keys: movie.frames.map((f) => f.key)};
  })())");
  EXPECT_EQ(film["times"], Json({0.2, 0.3, 0.4, 0.5, 0.6, 0.7}));
  EXPECT_EQ(film["size"], Json({160, 120})) << "even";
  EXPECT_NEAR(film["duration"].get<double>(), 1.2, 1e-3);
  EXPECT_EQ(film["keys"], Json({true, false, false, false, false, false}));
  EXPECT_LT(film["off"].get<double>(), 8) << "the last frame, among 256 levels";
  EXPECT_EQ(Js(size), before) << "the replay fills its stage again";
}

TEST_F(RunPageTest, KeysAndWhoCannotSeeThePage) {
  Open(Run(true, 0));
  const auto time = [&] { return Js("tenonReport.time()").get<double>(); };
  browser.Press("End");
  EXPECT_EQ(time(), 1);
  browser.Press("ArrowLeft", true);
  EXPECT_EQ(time(), 0);
  browser.Press("ArrowRight");
  EXPECT_NEAR(time(), 0.02, 1e-12);
  browser.Press("n");
  browser.Press("n");
  EXPECT_EQ(time(), 0.75) << "the second event";
  browser.Press("p");
  EXPECT_EQ(time(), 0.25);
  browser.Press("Home");
  EXPECT_EQ(time(), 0);
  browser.Press("]");
  EXPECT_EQ(Js("document.querySelector('#speed').value"), "2");
  browser.Press(" ");
  EXPECT_EQ(Js("tenonReport.playing()"), true);
  browser.Press(" ");
  EXPECT_EQ(Js("tenonReport.playing()"), false);
  browser.Press("f");
  EXPECT_EQ(Js("document.querySelector('#follow').checked"), false) << "it had followed what travels";
  browser.Press("?");
  EXPECT_EQ(Js("document.querySelector('#help').open"), true);
  EXPECT_THAT(Js("document.querySelector('#help').textContent").get<std::string>(),
              HasSubstrs("space", "play or pause", "light or dark"));
  const double before = time();
  browser.Press("End");
  EXPECT_EQ(time(), before) << "under the help, keys do nothing";
  Js("press(document.querySelector('#help'), 'close')");
  EXPECT_EQ(Js("document.querySelector('#help').open"), false);
  EXPECT_EQ(Js("document.querySelector('#run-bar, #live, #drive, #tune')"), nullptr) << "it has ended";

  Js("tenonReport.plots.edit(null)");
  EXPECT_EQ(testing::UnnamedControls(browser), Json::array());
}

TEST_F(RunPageTest, DrawsRowsAsTheyCome) {
  Open(Run(true, 0));
  Js(R"(tenonReport.append(0, {
    names: ['truth.output', 'measured.output', 'new'], units: ['N', 'N', 'm/s^2'], time: [1.5, 2], values: [[5, 7], [6, 8], [1, 2]],
    frames: {time: [2], columns: Array.from({length: 24}, (_, c) => c % 12 === 0 ? 4 : c % 12 === 11 || c % 12 === 3 ? 1 : 0)},
    events: [{time: 1.75, label: 'sent'}]}))");
  EXPECT_EQ(Js("tenonReport.duration()"), 2);
  EXPECT_EQ(Js("tenonReport.runs[0].find('new')[0].unit"), "m/s²");
  EXPECT_EQ(Js("plot('force').graph.xAxisRange()"), Json({0, 2})) << "who sees all goes on seeing all";
  EXPECT_EQ(Js("(tenonReport.seek(2), plot('force').series[0].text.textContent)"), "7.00 (8.00)");
  EXPECT_EQ(Js("tenonReport.replay.runs[0].actors[0].object.position.x"), 4);
  EXPECT_EQ(Js("tenonReport.replay.runs[0].actors[1].line.geometry.attributes.position.getX(51)"), 4)
      << "the path";
  browser.Press("p");
  EXPECT_EQ(Js("tenonReport.time()"), 1.75);
  EXPECT_THAT(Js("(() => { try { tenonReport.append(0, {names: ['new'], time: [3], values: [[1, 2]]}); } "
                 "catch (error) { return error.message; } })()")
                  .get<std::string>(),
              HasSubstr("new has 4 values at 3 times"));
}

// A box climbs a slope of 40 degrees on a rope of 30 m and feels a force that points to its middle.
TEST_F(RunPageTest, TheFirstViewShowsRobotSlopeAndForces) {
  const Geometry shapes{Shape::Box(ShapeRole::kBody, "robot", {0.6, 0.4, 0.3}),
                        Shape::Box(ShapeRole::kGround, "slope", {40, 40, 0.02}),
                        Shape::Segment(ShapeRole::kLine, "rope", 0.01),
                        Shape::Arrow(ShapeRole::kEstimate, "estimate", 0.01)};
  DiagramBuilder builder;
  auto& look = builder.AddFunction({"look"}, Uses(builder.time), [shapes](double t) {
    const double angle = -40 * std::numbers::pi / 180;
    const Vec<3> up(std::cos(angle), 0, -std::sin(angle)), place = up * t + Vec<3>(0, 0, 0.5);
    Geometry now = shapes;
    for (Shape& shape : now) shape.p_W = place;
    now[0].q_W = now[1].q_W = {std::cos(angle / 2), 0, std::sin(angle / 2), 0};
    now[1].p_W = {0, 0, 0};
    now[2].vector_W = 30 * up;
    now[3].vector_W = {0, 10, 0};
    now[3].p_W = place - Vec<3>(0, 0.05, 0);
    return now;
  });
  Simulator simulator(builder.Build());
  Report report({.title = "slope"});
  report.Log(simulator, {}, {&look});
  report.Conclude(simulator.AdvanceTo(3));
  Open(report);
  EXPECT_GT(Js("new THREE.Vector3(-Math.sin(0.698), 0, Math.cos(0.698))"
               ".dot(tenonReport.replay.camera.getWorldDirection(new THREE.Vector3()).negate())")
                .get<double>(),
            0.3)
      << "the slope is seen from above";
  const Json seen = Settle(R"((() => {
    const {camera, renderer, runs} = tenonReport.replay, at = (p) => p.clone().project(camera);
    const ends = runs[0].actors[0].points(0).map(at), across = (k) => (Math.max(...ends.map((p) => p[k])) - Math.min(...ends.map((p) => p[k]))) / 2;
    const canvas = document.createElement('canvas'), source = renderer.domElement, p = at(runs[0].actors[0].object.position);
    Object.assign(canvas, {width: source.width, height: source.height});
    const context = canvas.getContext('2d');
    context.drawImage(source, 0, 0);
    const [red, green, blue] = context.getImageData((1 + p.x) / 2 * source.width, (1 - p.y) / 2 * source.height, 1, 1).data;
    return {filled: Math.max(across('x'), across('y')), red, blue, following: tenonReport.replay.follow};
  })())");
  EXPECT_GT(seen["filled"].get<double>(), 0.6) << "the robot fills the view";
  EXPECT_LT(seen["filled"].get<double>(), 1);
  EXPECT_GT(seen["red"].get<int>(), seen["blue"].get<int>() + 20)
      << "the orange arrow shines through the blue box";
  EXPECT_EQ(seen["following"], true);
}

// Names of runs are names of directories, which may hold anything.
TEST_F(RunPageTest, AnyNameGivesWholeFiles) {
  Report both({.title = "a\x01", .plots = {{"force", {"truth.output"}, {}}}});
  both.Add("\"a\",\nb", Run(true, 0));
  both.Add("c\x01", Run(true, 0.5));
  Open(both);
  EXPECT_EQ(Js("plot('force').csv().split('\\n')[0]"),
            R"(time [s],"""a"", b: truth.output [N]",c : truth.output [N])");
  EXPECT_EQ(
      Js("[...tenonReport.pictures(600, 300).map((p) => p[1]), tenonReport.picture(0)].map((text) => new "
         "DOMParser().parseFromString(text, 'image/svg+xml').querySelectorAll('parsererror').length)"),
      Json({0, 0}));
}

TEST_F(RunPageTest, RunsSideBySide) {
  const Report a = Run(true, 0), b = Run(true, 0.5);
  Report both(
      {.title = "both", .plots = {{"cables", {"tension.output"}, {}}, {"force", {"truth.output"}, {}}}});
  both.Add("empty", a);
  both.Add("loaded", b);
  Open(both);
  EXPECT_EQ(Js("plot('cables').graph.numColumns()"), 3) << "an envelope for each run";
  EXPECT_EQ(Js("plot('force').series.map((s) => s.label)"), Json({"output", "output"}));
  EXPECT_EQ(Js("[...document.querySelectorAll('#figures tr.same')].map((r) => r.cells[0].title).slice(0, 2)"),
            Json({"com_error_max_m", "tilt_max_rad"}));
  EXPECT_THAT(Js("plot('force').csv().split('\\n')[0]").get<std::string>(),
              "time [s],empty: truth.output [N],loaded: truth.output [N]");
  browser.Press("v");
  browser.Press("g");
  EXPECT_EQ(Js("[tenonReport.replay.shown, tenonReport.replay.ghosts]"), Json({1, true}));
  const std::string groups = "tenonReport.replay.runs.map((run) => run.group.visible)";
  EXPECT_EQ(Js(groups), Json({true, true}));
  browser.Press("g");
  EXPECT_EQ(Js(groups), Json({false, true}));
  const std::string curves =
      "[...plot('force').box.querySelectorAll('.readout > div')].map((line) => !line.hidden)";
  EXPECT_EQ(Js(curves), Json({true, true}));
  Js("document.querySelectorAll('.verdict input')[0].click()");
  EXPECT_EQ(Js(curves), Json({false, true}));
}

}  // namespace tenon::report_page_test
