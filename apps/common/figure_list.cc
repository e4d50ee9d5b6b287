#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/tenon_report.h>
#include <tenon/systems/report/internal/browser.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/format.h>

namespace tenon::apps {

namespace {

namespace fs = std::filesystem;

struct FigureFile {
  std::vector<ThesisFigure> figures;

  static FieldList Fields() { return {Required("figures", &FigureFile::figures)}; }
};

std::string ListOf(const std::vector<ThesisFigure>& figures, const std::string& app) {
  std::string list;
  for (const ThesisFigure& figure : figures)
    if (figure.app == app)
      list += fmt::format("{:<6} {:<10} {}\n", figure.number, figure.scenario, figure.title);
  return list;
}

/// Returns the figure with a number. Throws ParameterError, also for a figure of another app.
const ThesisFigure& FigureOf(const std::vector<ThesisFigure>& figures, const std::string& number,
                             const std::string& app) {
  const auto found = std::ranges::find(figures, number, &ThesisFigure::number);
  if (found == figures.end())
    throw ParameterError(fmt::format("--figure {}: there is no such figure; {} makes\n{}",
                                     internal::Excerpt(number), app, ListOf(figures, app)));
  if (found->app != app)
    throw ParameterError(
        fmt::format("--figure {0}: {1} makes this figure; run {1} --figure {0}", number, found->app));
  return *found;
}

/// The scenario of a figure's run, with its plots, the settings of the command line, and drawn random values.
YamlDocument ScenarioOf(const ThesisFigure& figure, const FigureRun& run, const CommonArguments& arguments) {
  std::vector<std::string> settings = figure.set;
  for (const auto* more : {&run.set, &arguments.settings})
    settings.insert(settings.end(), more->begin(), more->end());
  YamlDocument document =
      LoadScenario(run.scenario.empty() ? figure.scenario : run.scenario, settings, figure.app);
  if (!figure.plots.empty()) {
    ReportScenario report;
    report.plots = figure.plots;
    document.Set("report.plots", YamlDocument::Parse(WriteYaml(report), "plots").Value("plots"));
  }
  document.Set("description",
               fmt::format("\"figure {}, {}; the thesis: {}\"", figure.number, figure.title, figure.thesis));
  DrawScenario(document, arguments.seed);
  return document;
}

/// Saves plots and pictures of a report beside it.
void DrawFigure(const ThesisFigure& figure, const fs::path& out, double end) {
  if (!internal::Browser::IsInstalled()) {
    Say("the figure is in report.html; to save it as files, too, install Chromium: apt-get install "
        "chromium\n");
    return;
  }
  if (!figure.plots.empty()) DrawPictures(out, {.svg = (out / "figure").string()});
  for (std::size_t i = 0; i < figure.pictures_s.size(); ++i)
    DrawPictures(out, {.frame = std::pair(std::min(figure.pictures_s[i], end),
                                          (out / fmt::format("picture_{}.png", i + 1)).string())});
}

}  // namespace

std::vector<ThesisFigure> LoadFigures(const std::string& name) {
  return LoadResource("figures", YamlFile{name}).Read<FigureFile>().figures;
}

int RunFigure(const ScenarioApp& app, const CommonArguments& arguments) {
  const std::vector<ThesisFigure> figures = LoadFigures(app.figures);
  if (arguments.figure == kListFigures) {
    fmt::print("{}", ListOf(figures, app.name));
    return kRan;
  }
  if (!arguments.live.empty() || !arguments.replay.empty())
    throw ParameterError("--figure runs a scenario to its end: remove --live and --replay");
  const ThesisFigure& figure = FigureOf(figures, arguments.figure, app.name);
  RunOptions options = OptionsOf(arguments);
  if (arguments.out.empty()) options.out = fs::path("out") / ("figure_" + figure.number);
  const std::string title = fmt::format("Figure {}: {}", figure.number, figure.title);
  const auto run = [&](const FigureRun& which, const RunOptions& each) {
    return app.run(ScenarioOf(figure, which, arguments), arguments.duration, each);
  };
  int code = kRan;
  double end = 0;  // of the longest run [s]
  const auto note_end = [&](const Summary& summary) {
    for (const auto& [key, text] : summary.Flat())
      if (key == "simulated_s") end = std::max(end, internal::NumberIn<double>(text).value_or(0));
  };
  if (figure.runs.empty()) {
    const RunResult result = run({}, options);
    note_end(result.summary);
    code = PrintResult(result.summary, options);
  } else {
    std::vector<Variant> variants;
    for (const FigureRun& which : figure.runs)
      variants.push_back({which.name, [&, which](const RunOptions& each) {
                            RunResult result = run(which, each);
                            note_end(result.summary);
                            return result;
                          }});
    code = Compare(
        options,
        Report({.title = title, .description = "the thesis: " + figure.thesis, .plots = figure.plots}),
        variants);
  }
  fmt::print("{:<28} {}\n{:<28} {}\n", "figure", title, "the thesis reports", figure.thesis);
  if (code != kOutputFailed && code < 128) DrawFigure(figure, options.out, end);
  return code;
}

}  // namespace tenon::apps
