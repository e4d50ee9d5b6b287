#include <tenon/systems/report/internal/run_log.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::report_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::ElementsAre, ::testing::IsEmpty, ::testing::SizeIs;

using testing::DataOf;

template <class T>
std::vector<T> Numbers(const Json& json) {
  return internal::FromBase64<T>(json.get<std::string>());
}

/// The samples of a signal in a run of a page: times and values.
struct Samples {
  std::string unit;
  std::vector<double> time;
  std::vector<float> values;
};
Samples SamplesOf(const Json& run, const std::string& name) {
  const Json& time = run.at("samples").at("time");
  const auto times = time.is_string() ? Numbers<double>(time) : std::vector<double>();
  for (const Json& group : run.at("samples").at("groups")) {
    for (const Json& column : group.at("columns")) {
      if (column.at("name") != name) continue;
      Samples samples{column.at("unit"), {}, Numbers<float>(column.at("values"))};
      for (const std::uint16_t row : Numbers<std::uint16_t>(group.at("rows")))
        samples.time.push_back(time.is_string()
                                   ? times.at(row)
                                   : time.at("start").get<double>() + row * time.at("step").get<double>());
      return samples;
    }
  }
  ADD_FAILURE() << "the page has no signal " << name;
  return {};
}

/// A cart that moves, drawn with an arrow, a wall and a mesh.
struct ReportTest : ::testing::Test {
  ReportTest() {
    cart = &builder.Add<Cart>("cart");
    force = &builder.AddFunction({"force", "N"}, Sampled{Hz(10)}, Uses(builder.time),
                                 [](double t) { return t < 0.45 ? 2.0 : -1.5; });
    builder.Connect(*force, cart->force);
    Geometry model{Shape::Box(ShapeRole::kBody, "cart", {0.3, 0.2, 0.1}),
                   Shape::Arrow(ShapeRole::kForce, "push", 0.1),
                   Shape::Box(ShapeRole::kGround, "wall", {0.1, 1, 1}),
                   Shape::Mesh(ShapeRole::kFixture, "sail",
                               std::make_shared<const TriangleMesh>(
                                   TriangleMesh{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}))};
    model[2].p_W = {2, 0, 0.5};
    geometry = &builder.Add<Look>("look", model).geometry;
    builder.Connect(cart->state, static_cast<Look&>(const_cast<System&>(geometry->owner())).x);
    diagram = builder.Build();
    file = test::TemporaryPath("tenon_report_" +
                               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) +
                               ".html");
  }
  ~ReportTest() override { fs::remove(file); }

  /// The shapes of the cart.
  struct Look final : Leaf {
    explicit Look(const Geometry& model) : geometry(this, {"geometry"}, model, Uses(x), &Look::Calc) {}
    InputPort<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
    OutputPort<Geometry> geometry;

   private:
    void Calc(const Vec<2>& x, Geometry* out) const {
      (*out)[0].p_W = {x[0], 0, 0.05};
      (*out)[1].p_W = (*out)[0].p_W;
      (*out)[1].vector_W = {x[1], 0, 0};
    }
  };

  Report Run(ReportParams params) {
    Report report(std::move(params));
    Simulator simulator(*diagram);
    report.Log(simulator, {&cart->state, force}, {geometry});
    report.Conclude(simulator.AdvanceTo(1));
    return report;
  }

  DiagramBuilder builder;
  Cart* cart;
  OutputPort<double>* force;
  const OutputPort<Geometry>* geometry;
  std::shared_ptr<const Diagram> diagram;
  fs::path file;
};

TEST_F(ReportTest, ThreeLinesMakeAPage) {
  Simulator simulator(*diagram);
  Report report({.title = "cart"});
  report.Log(simulator, {&cart->state}, {geometry});
  simulator.RunTo(1);
  report.Write(file);
  const Json data = DataOf(file);
  ASSERT_THAT(data["plots"], SizeIs(2)) << "position and velocity have two units";
  EXPECT_EQ(data["plots"][0]["signals"], Json({"cart.x.position"}));
  EXPECT_EQ(SamplesOf(data["runs"][0], "cart.x.velocity").unit, "m/s");
  const std::string page = ReadText(file);
  for (const char* part :
       {"<title>cart</title>", "OrbitControls = function", "Dygraph", "class Replay", ".dygraph-axis-label"})
    EXPECT_TRUE(page.find(part) != std::string::npos) << part;
  EXPECT_EQ(page.find("sourceMappingURL"), std::string::npos) << "a page of one file has no source maps";
}

TEST_F(ReportTest, PlotsHoldWhatWasLogged) {
  Run({.title = "cart", .plots = {{"speed", {"cart.x.velocity"}, {"force.output"}}}, .signal_rate = Hz(10)})
      .Write(file);
  const Json data = DataOf(file), run = data.at("runs").at(0);
  EXPECT_EQ(data["plots"], Json::parse(R"([{"title": "speed", "group": "", "signals": ["cart.x.velocity"],
                                            "references": ["force.output"]}])"));
  const Samples speed = SamplesOf(run, "cart.x.velocity");
  ASSERT_THAT(speed.time, SizeIs(11));
  EXPECT_DOUBLE_EQ(speed.time[3], 0.3);
  EXPECT_FLOAT_EQ(speed.values[4], 2.0F / 2 * 0.4F) << "v = F t / m";
  EXPECT_EQ(SamplesOf(run, "force.output").time, speed.time) << "a reference has the times of its signal";
}

// The prefixes of a plot's signals: the norm of x = (position, velocity), and the rate of the position, which
// is the mean velocity between two rows.
TEST_F(ReportTest, PlotsDeriveNormsAndRates) {
  Report report({.title = "cart",
                 .plots = {{"size", {"norm:cart.x"}, {"cart.x.position"}},
                           {"speed", {"rate:cart.x.position"}, {"cart.x.velocity"}}}});
  Simulator simulator(*diagram);
  report.Log(simulator, {&cart->state});
  static_cast<void>(simulator.AdvanceTo(1));
  report.Write(file);
  const Json run = DataOf(file).at("runs").at(0);
  const Samples norm = SamplesOf(run, "norm:cart.x"), rate = SamplesOf(run, "rate:cart.x.position");
  const Samples x = SamplesOf(run, "cart.x.position"), v = SamplesOf(run, "cart.x.velocity");
  ASSERT_EQ(norm.values.size(), 201);
  EXPECT_EQ(norm.unit, "m");
  EXPECT_EQ(rate.unit, "m/s");
  EXPECT_TRUE(std::isnan(rate.values[0])) << "no row before the first one";
  for (std::size_t i = 1; i < norm.values.size(); ++i) {
    EXPECT_FLOAT_EQ(norm.values[i], std::hypot(x.values[i], v.values[i]));
    EXPECT_NEAR(rate.values[i], (v.values[i] + v.values[i - 1]) / 2, 0.011) << "a force of 2 N jumps to -1.5";
  }
}

TEST_F(ReportTest, PathsNeedTwoElementsAndPlotsOfTheirOwn) {
  const auto make = [&](std::vector<std::string> signals) {
    Report report({.title = "cart", .plots = {{"path", std::move(signals)}}});
    Simulator simulator(*diagram);
    report.Log(simulator, {&cart->state, force});
  };
  make({"xy:cart.x"});
  EXPECT_TRUE(Throws<ParameterError>([&] { make({"xy:force.output"}); }, "xy:force.output"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({"xy:cart.x", "cart.x"}); }, "path"));
  EXPECT_TRUE(Throws<ParameterError>([&] { make({"norm:cart.y"}); }, "cart.x"));
}

TEST_F(ReportTest, SignalsThatNoPlotShowsAreThereToo) {
  Run({.title = "cart", .plots = {{"speed", {"cart.x.velocity"}, {}}}, .signal_rate = Hz(10)}).Write(file);
  const Json run = DataOf(file).at("runs").at(0);
  EXPECT_THAT(SamplesOf(run, "cart.x.position").time, SizeIs(11));
  const Samples force = SamplesOf(run, "force.output");  // steps once: rows between say nothing
  EXPECT_THAT(force.values, ElementsAre(2, 2, -1.5, -1.5));
  EXPECT_DOUBLE_EQ(force.time[1], 0.4);
  EXPECT_DOUBLE_EQ(force.time[2], 0.5);
}

TEST_F(ReportTest, LimitsOfSignalsAndFigures) {
  Report report = Run({.title = "cart", .limits = {{"cart.x.velocity", {.low = -1, .high = 0.5}}}});
  report.AddFigure("force_max_N", 3, {.high = 2.5});
  report.Write(file);
  const Json run = DataOf(file).at("runs").at(0);
  EXPECT_EQ(run["limits"], Json::parse(R"([{"signal": "cart.x.velocity", "limits": [-1.0, 0.5]}])"));
  EXPECT_EQ(run["figures"], Json::parse(R"([{"name": "force_max_N", "value": 3.0, "limits": [null, 2.5]}])"));
}

TEST_F(ReportTest, FramesHoldWhatMovesAndTheRestOnce) {
  Run({.title = "cart", .frame_rate = Hz(20)}).Write(file);
  const Json frames = DataOf(file).at("runs").at(0).at("frames");
  EXPECT_EQ(frames["shapes"][0], (Json{{"kind", "box"},
                                       {"role", "bodies"},
                                       {"name", "cart"},
                                       {"size", {0.3, 0.2, 0.1}},
                                       {"scale", 1.0},
                                       {"unit", ""}}));
  EXPECT_EQ(frames["shapes"][1]["scale"], 0.1);
  EXPECT_THAT(Numbers<float>(frames["shapes"][3]["corners"]), ElementsAre(0, 0, 1, 1, 0, 0, 0, 1, 0));
  EXPECT_THAT(Numbers<std::uint32_t>(frames["shapes"][3]["triangles"]), ElementsAre(0, 1, 2));
  // Twelve numbers a shape: position x of cart and arrow, and the arrow's vector x move.
  EXPECT_THAT(frames["moving"], ElementsAre(0, 12, 12 + 7));
  const auto first = Numbers<float>(frames["first"]);
  ASSERT_THAT(first, SizeIs(48));
  EXPECT_EQ(first[24], 2) << "the wall";
  const auto data = Numbers<float>(frames["data"]);
  ASSERT_THAT(data, SizeIs(3 * 21));
  EXPECT_FLOAT_EQ(data[8], 0.5F * 0.4F * 0.4F) << "x = F t^2 / 2 m at 0.4 s";
}

TEST_F(ReportTest, ChangesOfASignalAreEvents) {
  Run({.title = "cart", .plots = {{"x", {"cart.x"}, {}}}, .events = {"force.output"}, .signal_rate = Hz(10)})
      .Write(file);
  const Json events = DataOf(file).at("runs").at(0).at("events");
  ASSERT_THAT(events, SizeIs(1));
  EXPECT_EQ(events[0]["time"], 0.5);
  EXPECT_EQ(events[0]["label"], "force.output 2 → -1.5 N");
}

TEST_F(ReportTest, ModesAreBands) {
  Run({.title = "cart",
       .plots = {{"x", {"cart.x"}, {}}},
       .bands = {{"force.output", {"a", "b", "push"}}},
       .signal_rate = Hz(10)})
      .Write(file);
  const Json bands = DataOf(file).at("runs").at(0).at("bands");
  EXPECT_EQ(bands, Json::parse(R"([{"signal": "force.output", "names": ["a", "b", "push"],
                                    "intervals": [{"time": 0.0, "value": 2.0, "name": "push"},
                                                  {"time": 0.5, "value": -1.5, "name": "-1.5"}]}])"));
}

// A mode that changes at every sample: the last band says that no more changes are shown.
TEST_F(ReportTest, BandsOfManyChangesEndWithAWord) {
  DiagramBuilder fast;
  const auto& mode = fast.AddFunction("mode", Sampled{Hz(1000)}, Uses(fast.time),
                                      [](double t) { return std::lround(1000 * t) % 2 == 0 ? 0.0 : 1.0; });
  Simulator simulator(fast.Build());
  Report report({.title = "modes", .bands = {{"mode.output", {"a", "b"}}}, .signal_rate = Hz(1000)});
  report.Log(simulator, {&mode});
  report.Conclude(simulator.AdvanceTo(2));
  report.Write(file);
  const Json intervals = DataOf(file).at("runs").at(0).at("bands").at(0).at("intervals");
  ASSERT_THAT(intervals, SizeIs(1001));
  EXPECT_EQ(intervals[999]["name"], "b");
  EXPECT_NE(intervals[1000]["name"], "");
  EXPECT_TRUE(intervals[1000]["value"].is_null());
}

TEST_F(ReportTest, VerdictFiguresAndEvents) {
  Report report = Run({.title = "cart"});
  report.AddFigure("error_max_m", 0.25);
  report.AddFigure("settling_time_s", std::nullopt);
  report.AddFigure("controller", "pd");
  report.AddEvent(0.3, "kick");
  report.Write(file);
  Json run = DataOf(file).at("runs").at(0);
  EXPECT_EQ(run["good"], true);
  EXPECT_EQ(run["verdict"], "finished after 1 s");
  EXPECT_EQ(
      run["figures"],
      Json::parse(R"([{"name": "error_max_m", "value": 0.25}, {"name": "settling_time_s", "value": null},
                            {"name": "controller", "value": "pd"}])"));
  EXPECT_EQ(run["events"][0]["label"], "kick");

  report.Conclude({.time = 0.7, .ended = true, .reason = "monitor: too fast"});
  report.Write(file);
  run = DataOf(file).at("runs").at(0);
  EXPECT_EQ(run["good"], false);
  EXPECT_EQ(run["verdict"], "ended at 0.7 s: monitor: too fast");
  EXPECT_EQ(run["events"][1]["label"], "monitor: too fast");
}

TEST_F(ReportTest, TextCannotBreakThePage) {
  Report report = Run({.title = "a <b> & </script><script>alert(1)</script>", .description = "<!-- \xff"});
  report.Write(file);
  EXPECT_EQ(DataOf(file).at("title"), "a <b> & </script><script>alert(1)</script>");
  EXPECT_TRUE(ReadText(file).find("<title>a &lt;b> &amp; &lt;/script>") != std::string::npos);
}

TEST_F(ReportTest, WrongNameIsRefusedBeforeTheRun) {
  Simulator simulator(*diagram);
  const auto refuses = [&](ReportParams params, const char* place, const char* name) {
    Report report(std::move(params));
    return Throws<ParameterError>([&] { report.Log(simulator, {&cart->state, force}); }, place, name);
  };
  EXPECT_TRUE(refuses({.plots = {{"speed", {"cart.x.velocty"}, {}}}}, "'speed'", "'cart.x.velocity'"));
  EXPECT_TRUE(refuses({.plots = {{"speed", {"cart.x"}, {"cart.y"}}}}, "'speed'", "'cart.y'"));
  EXPECT_TRUE(refuses({.bands = {{"forc", {}}}}, "bands", "'forc'"));
  EXPECT_TRUE(refuses({.limits = {{"forc", {}}}}, "limits", "'forc'"));
  EXPECT_TRUE(refuses({.events = {"forc"}}, "events", "'forc'"));
}

TEST_F(ReportTest, WrongUseIsRefused) {
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        Report({.title = "cart", .plots = {{"empty", {}, {}}}});
      },
      "'empty'"));
  Simulator simulator(*diagram);
  Report report({.title = "cart"});
  EXPECT_TRUE(Throws<RunError>([&] { report.Write(file); }, "empty"));
  report.Log(simulator, {&cart->state});
  EXPECT_TRUE(Throws<Error>([&] { report.Log(simulator, {&cart->state}); }, "Add"));
  EXPECT_TRUE(Throws<RunError>([&] { report.Write("/nowhere/report.html"); }, "'/nowhere/report.html'"));
  Report none({.title = "none"});
  EXPECT_TRUE(Throws<Error>([&] { report.Add("variant", none); }, "'variant'"));
}

TEST_F(ReportTest, MissingLibraryIsToldWithItsPackageBeforeTheRun) {
  setenv("TENON_JAVASCRIPT_DIR", "/nowhere", 1);
  EXPECT_TRUE(Throws<RunError>([] { Report({.title = "cart"}); }, "/nowhere/dygraphs/dygraph.min.css",
                               "TENON_JAVASCRIPT_DIR"));
  unsetenv("TENON_JAVASCRIPT_DIR");
}

TEST_F(ReportTest, ReportMayEndBeforeTheSimulator) {
  Simulator simulator(*diagram);
  { Report({.title = "cart"}).Log(simulator, {&cart->state}, {geometry}); }
  EXPECT_NO_THROW(simulator.RunTo(0.1));
}

TEST_F(ReportTest, VariantsShareOnePage) {
  Report slow = Run({.title = "slow"}), fast = Run({.title = "fast"});
  slow.AddFigure("error_m", 1.0);
  fast.AddFigure("error_m", 2.0);
  Report both({.title = "both", .plots = {{"x", {"cart.x.position"}, {}}}});
  both.Add("slow", slow);
  both.Add("fast", fast);
  both.Write(file);
  const Json runs = DataOf(file).at("runs");
  ASSERT_THAT(runs, SizeIs(2));
  EXPECT_EQ(runs[0]["name"], "slow");
  EXPECT_EQ(runs[1]["figures"][0]["value"], 2.0);
  EXPECT_THAT(SamplesOf(runs[1], "cart.x.position").values, SizeIs(201));
}

/// The directory that an app writes for a run.
struct ReadReportTest : ReportTest {
  ReadReportTest() : directory(file.parent_path() / (file.stem().string() + "_run")) {
    fs::create_directories(directory);
  }
  ~ReadReportTest() override { fs::remove_all(directory); }
  void WriteRun() {
    Report report({.title = "cart",
                   .description = "of two kilogrammes",
                   .plots = {{"speed", {"cart.x.velocity"}, {"force.output"}, "motion"}},
                   .events = {"force"},
                   .bands = {{"force.output", {"a", "b", "push"}}},
                   .limits = {{"force", {.high = 3}}}});
    Simulator simulator(*diagram);
    report.Log(simulator, {&cart->state, force}, {geometry});
    simulator.AddLog(Hz(200), {&cart->state, force}, {std::make_shared<CsvLog>(directory / "signals.csv")});
    report.Conclude(simulator.AdvanceTo(1));
    report.AddFigure("error_max_m", 0.1, {.low = 0});
    report.AddFigure("controller", "pd");
    report.Write(directory / "report.html");
  }
  void ExpectRefused(const std::string& what, const std::string& place = "") {
    EXPECT_TRUE(Throws<ParameterError>([&] { Report::Read(directory); }, directory.string() + place, what));
  }
  const fs::path directory;
};

TEST_F(ReadReportTest, ARunThatIsReadIsTheOneThatWasWritten) {
  WriteRun();
  const Report read = Report::Read(directory);
  EXPECT_EQ(read.params().title, "cart");
  read.Write(file);
  Json written = DataOf(directory / "report.html"), again = DataOf(file);
  for (const char* name : {"cart.x.position", "cart.x.velocity", "force.output"}) {
    const Samples before = SamplesOf(written["runs"][0], name), after = SamplesOf(again["runs"][0], name);
    EXPECT_THAT(after.values, ::testing::Pointwise(::testing::FloatEq(), before.values));  // by nine digits
    EXPECT_EQ(after.time, before.time);
  }
  written["runs"][0].erase("samples");
  again["runs"][0].erase("samples");
  EXPECT_EQ(again, written);
  Report twice(
      {.title = "twice", .plots = {{"position, which its own page does not plot", {"cart.x.position"}, {}}}});
  twice.Add("a", read);
  twice.Add("b", read);
  twice.Write(file);
  const Json runs = DataOf(file).at("runs");
  EXPECT_EQ(SamplesOf(runs[1], "cart.x.position").values, SamplesOf(runs[0], "cart.x.position").values);
  EXPECT_FLOAT_EQ(SamplesOf(runs[0], "cart.x.position").values.at(80), 0.5F * 0.4F * 0.4F);
}

TEST_F(ReadReportTest, WhatIsMissingOrWrongIsNamed) {
  EXPECT_TRUE(Throws<ParameterError>([&] { Report::Read(directory / "nowhere"); }, "nowhere'"));
  ExpectRefused("report.html");
  WriteRun();
  fs::rename(directory / "signals.csv", directory / "moved.csv");
  ExpectRefused("signals.csv");
  std::string signals = ReadText(directory / "moved.csv");
  const auto write = [](const fs::path& path, const std::string& text) { std::ofstream(path) << text; };
  write(directory / "signals.csv", signals + "1.005,1,2\n");
  ExpectRefused("3 values", "/signals.csv', line 203");
  write(directory / "signals.csv", signals + "1.005,1,2,x\n");
  ExpectRefused("'x'", "/signals.csv', line 203");
  write(directory / "signals.csv", "x" + signals);
  ExpectRefused("time", "/signals.csv', line 1");
  write(directory / "signals.csv", signals);
  const std::string page = ReadText(directory / "report.html");
  write(directory / "report.html", page.substr(0, page.size() / 2));
  ExpectRefused("", "/report.html");
  write(directory / "report.html", "<html></html>");
  ExpectRefused("", "/report.html");
  Report both({.title = "both"});
  for (const char* name : {"a", "b"}) both.Add(name, Run({.title = name}));
  both.Write(directory / "report.html");
  ExpectRefused("", "/report.html");
}

/// A hundred arrows that all move, and as many signals.
struct Swarm final : LeafSystem<void> {
  OutputPort<Vec<100>> waves{
      this, {"waves"}, Uses(time), [](double t) {
        return Vec<100>(Vec<100>::LinSpaced(1, 100).unaryExpr([t](double f) { return std::sin(f * t); }));
      }};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                Geometry(100, Shape::Arrow(ShapeRole::kForce, "arrow", 1)),
                                Uses(time),
                                [](double t, Geometry* out) {
                                  for (Shape& shape : *out) {
                                    shape.p_W.setConstant(t);
                                    shape.vector_W.setConstant(2 * t);
                                  }
                                }};
};

TEST(ReportSizeTest, LongRunOfManyShapesStaysBelowTenMegabytes) {
  DiagramBuilder builder;
  auto& swarm = builder.Add<Swarm>("swarm");
  Simulator simulator(builder.Build());
  Report report(
      {.title = "swarm", .plots = {{"some", {"swarm.waves.0", "swarm.waves.1", "swarm.waves.99"}, {}}}});
  report.Log(simulator, {&swarm.waves}, {&swarm.geometry});
  simulator.RunTo(90);  // longer than all rows are kept
  const fs::path file = test::TemporaryPath("tenon_report_size.html");
  Report eight({.title = "eight"});
  for (int i = 0; i < 8; ++i) eight.Add(std::to_string(i), report);
  eight.Write(file);
  EXPECT_LT(fs::file_size(file), 10'000'000) << "eight runs, all signals plotted";
  report.Write(file);
  EXPECT_LT(fs::file_size(file), 10'000'000);
  EXPECT_GE(SamplesOf(DataOf(file).at("runs").at(0), "swarm.waves.99").time.size(), 3000);
  EXPECT_GE(SamplesOf(DataOf(file).at("runs").at(0), "swarm.waves.50").time.size(), 1000);
  const Json frames = DataOf(file).at("runs").at(0).at("frames");
  EXPECT_THAT(frames["moving"], SizeIs(600));
  const auto time = Numbers<double>(frames["time"]);
  EXPECT_GE(time.size(), 700) << "8 frames a second are left";
  EXPECT_EQ(time.back(), 90) << "the end is kept";
  fs::remove(file);
}

using Thinning = internal::ColumnLog::Thinning;

// The run has 1000 times more rows than the log keeps.
TEST(ColumnLogTest, KeepsThePeaksOfALongRunInLittleMemory) {
  internal::ColumnLog log(Thinning::kPeaks, 256, nullptr);
  log.Begin({"time", "wave", "steps", "peak"}, {"s", "", "", ""});
  constexpr int kRows = 256000;
  for (int i = 0; i < kRows; ++i)
    log.Row(std::vector<double>{1e-3 * i, std::sin(1e-4 * i), i < kRows / 2 ? 1.0 : 0.0,
                                i == 77777 ? 9.0 : -9.0});
  EXPECT_LE(log.rows(), 256);
  EXPECT_GE(log.rows(), 128 - 2);
  float peak = -10;
  int falls = 0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    EXPECT_NEAR(log.at(row, 0), std::sin(0.1 * log.time(row)), 0.4) << row;  // within its interval of 2 s
    peak = std::max(peak, log.at(row, 2));
    if (row == 0) continue;
    EXPECT_GT(log.time(row), log.time(row - 1));
    EXPECT_LE(log.at(row, 1), log.at(row - 1, 1)) << "in the order in which they came";
    falls += log.at(row, 1) < log.at(row - 1, 1);
  }
  EXPECT_EQ(peak, 9);
  EXPECT_EQ(falls, 1);
  EXPECT_NEAR(log.time(log.rows() - 1), 1e-3 * (kRows - 1), 4) << "the end is there";
}

// A sensor without a value at most samples.
TEST(ColumnLogTest, PeaksAreThoseOfTheNumbersAmongNoNumbers) {
  internal::ColumnLog log(Thinning::kPeaks, 64, nullptr);
  log.Begin({"time", "x", "never"}, {"s", "", ""});
  for (int i = 0; i < 64000; ++i) {
    const double x = i == 33333 ? 9 : i % 7 == 3 ? 1 : NAN;
    log.Row(std::vector<double>{1e-3 * i, x, NAN});
  }
  float peak = -1;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    EXPECT_FALSE(std::isnan(log.at(row, 0))) << row;
    EXPECT_TRUE(std::isnan(log.at(row, 1))) << row;
    peak = std::max(peak, log.at(row, 0));
  }
  EXPECT_EQ(peak, 9);
  std::vector<float> drawn;
  for (const std::size_t row : DecimatePeaks(log, {0}, 12)) drawn.push_back(log.at(row, 0));
  EXPECT_THAT(drawn, ::testing::Contains(9.0F));
}

// A run that is set back keeps the rows before that time and those after the restart, within its size.
TEST(ColumnLogTest, ARunThatIsSetBackLeavesNoTrace) {
  for (const Thinning thinning : {Thinning::kPeaks, Thinning::kSample}) {
    for (const int rows : {10, 63, 5000}) {
      internal::ColumnLog log(thinning, 64, nullptr);
      log.Begin({"time", "a"}, {"s", ""});
      for (int i = 0; i < rows; ++i) log.Row(std::vector<double>{1.0 * i, 1});
      const int back = rows * 2 / 3;
      log.DropFrom(back, false);
      for (int i = back; i < rows; ++i) log.Row(std::vector<double>{1.0 * i, i == rows - 3 ? 7.0 : 2.0});
      EXPECT_LE(log.rows(), 65U);
      EXPECT_GE(log.time(log.rows() - 1), rows - 1 - rows / 16);
      float peak = 0;
      for (std::size_t row = 0; row < log.rows(); ++row) {
        if (row > 0) {
          EXPECT_GT(log.time(row), log.time(row - 1));
        }
        EXPECT_EQ(log.at(row, 0) == 1, log.time(row) < back) << log.time(row);
        peak = std::max(peak, log.at(row, 0));
      }
      if (thinning == Thinning::kPeaks) {
        EXPECT_EQ(peak, 7) << rows;
      }
    }
  }
}

TEST(ColumnLogTest, SamplesAreEvenlySpacedRowsAndEndWithTheRun) {
  for (const int rows : {1, 2, 63, 64, 65, 127, 128, 129, 8191, 8192, 8193, 10000}) {
    internal::ColumnLog log(Thinning::kSample, 64, nullptr);
    log.Begin({"time", "a", "b"}, {"s", "", ""});
    for (int i = 0; i < rows; ++i) log.Row(std::vector<double>{1.0 * i, 2.0 * i, -3.0 * i});
    EXPECT_LE(log.rows(), 65U);
    EXPECT_GE(log.rows(), static_cast<std::size_t>(std::min(rows, 32)));
    for (std::size_t row = 0; row < log.rows(); ++row) {
      EXPECT_EQ(log.at(row, 0), 2 * log.time(row));
      EXPECT_EQ(log.at(row, 1), -3 * log.time(row));
      if (row == 0 || row + 1 == log.rows()) continue;
      EXPECT_EQ(log.time(row) - log.time(row - 1), log.time(1)) << rows;
    }
    EXPECT_EQ(log.time(log.rows() - 1), rows - 1);
  }
}

TEST(DecimatePeaksTest, KeepsEveryPeakAndTheLimit) {
  internal::ColumnLog log(Thinning::kPeaks, 1 << 17, nullptr);
  log.Begin({"time", "a", "b"}, {"s", "", ""});
  for (int i = 0; i < 100000; ++i) {
    const double t = 1e-3 * i;
    log.Row(std::vector<double>{t, std::sin(t) + (i == 31415 ? 9 : 0), i == 77777 ? -5 : std::cos(3 * t)});
  }
  const std::vector<std::size_t> rows = internal::DecimatePeaks(log, {0, 1}, 1000);
  EXPECT_LE(rows.size(), 1001);
  EXPECT_GE(rows.size(), 300);
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
  EXPECT_EQ(rows.front(), 0);
  EXPECT_EQ(rows.back(), 99999);
  EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), 31415));
  EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), 77777));
  // In each 5 % of the run the extremes are those of all rows.
  for (std::size_t begin = 0; begin < 100000; begin += 5000) {
    float all = -10, kept = -10;
    for (std::size_t i = begin; i < begin + 5000; ++i) all = std::max(all, log.at(i, 0));
    for (const std::size_t i : rows) {
      if (i >= begin && i < begin + 5000) kept = std::max(kept, log.at(i, 0));
    }
    EXPECT_NEAR(kept, all, 1e-6);
  }
}

TEST(DecimatePeaksTest, KeepsAllRowsOfAShortLog) {
  internal::ColumnLog log(Thinning::kPeaks, 1 << 17, nullptr);
  EXPECT_THAT(internal::DecimatePeaks(log, {}, 10), IsEmpty());
  log.Begin({"time", "a"}, {"s", ""});
  for (int i = 0; i < 4; ++i) log.Row(std::vector<double>{1.0 * i, 1.0});
  EXPECT_THAT(internal::DecimatePeaks(log, {0}, 10), ElementsAre(0, 1, 2, 3));
}

TEST(Base64Test, AgreesWithOthers) {
  // python3 -c "import base64, struct; print(base64.b64encode(struct.pack('<d', 1)))"
  EXPECT_EQ(internal::Base64(std::vector<double>{1}), "AAAAAAAA8D8=");
  EXPECT_EQ(internal::Base64(std::vector<float>{1}), "AACAPw==");
  EXPECT_EQ(internal::Base64(std::vector<float>{-2.5F, 3e7F, 0.1F}), "AAAgwMDh5EvNzMw9");
  EXPECT_EQ(internal::Base64(std::vector<float>{}), "");
  EXPECT_EQ(internal::Base64(std::vector<std::uint16_t>{1, 65535}), "AQD//w==");
  EXPECT_THAT(internal::FromBase64<float>("AAAgwMDh5EvNzMw9"), ElementsAre(-2.5F, 3e7F, 0.1F));
  EXPECT_THROW(internal::FromBase64<float>("AA-gwMDh5EvNzMw9"), std::out_of_range);
}

}  // namespace tenon::report_test
