#include <tenon/apps/common/run_scenario.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <set>

namespace tenon::apps {

namespace fs = std::filesystem;

void PrintReportPath(const fs::path& directory) {
  const fs::path report = directory / "report.html";
  std::error_code ignored;
  if (!directory.empty() && fs::exists(report, ignored))
    fmt::print("\n{:<28} {}\n", "report", report.string());
}

int PrintResult(const Summary& summary, const RunOptions& options) {
  summary.Print();
  PrintReportPath(options.out);
  return summary.exit_code();
}

void SetParameters(Context& context, const std::map<std::string, std::vector<double>>& values) {
  if (values.empty()) return;
  std::vector<std::string> paths;
  for (const internal::ParameterSource* parameter : context.diagram().parameters())
    paths.push_back(parameter->path());
  for (const auto& [path, numbers] : values) {
    const std::string key = "parameters." + path;
    try {
      if (std::ranges::count(paths, path) == 0)
        throw ParameterError(fmt::format("the diagram has no Parameter '{}'; did you mean '{}'?", path,
                                         internal::NearestName(path, paths)));
      context.SetDoubles(context.diagram().Find(path), numbers);
    } catch (const Error& error) {
      throw KeyError(key, error.what());
    }
  }
}

void PrintNotes(const RunOptions& options, const std::vector<std::string>& notes) {
  for (const std::string& note : notes)
    Say(fmt::format("{}warning: {}\n", options.name.empty() ? "" : options.name + ": ", note));
}

std::shared_ptr<LogSink> InBackground(std::shared_ptr<LogSink> sink) {
  return std::make_shared<BackgroundLog>(std::vector{std::move(sink)});
}

int TryToWrite(const std::function<void()>& write) {
  try {
    write();
    return kRan;
  } catch (const OutputError& error) {
    Say(fmt::format("{}\n", error.what()));
    return kOutputFailed;
  } catch (const std::bad_alloc&) {
    Say("out of memory while writing the results: reduce log_rate_hz\n");
    return kNumericalFailure;
  }
}

void WriteResults(const fs::path& directory, Summary& summary, Report& report) {
  summary.AddTo(report);
  int code = TryToWrite([&] { summary.Write(directory / "summary.json"); });
  code = std::max(code, TryToWrite([&] { report.Write(directory / "report.html"); }));
  if (code != kRan) summary.set_exit_code(code);
}

int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants) {
  std::set<std::string_view> names;
  for (const Variant& variant : variants)
    if (!names.insert(variant.name).second)
      throw ParameterError(fmt::format("two variants have the name '{}': remove one of them", variant.name));
  const OutputDirectory out(options.out);
  for (const Variant& variant : variants)
    OutputDirectory(out.path() / variant.name);  // also if a signal prevents its run
  Summary::Named runs;
  std::vector<Report> reports;
  int worst = kRan;
  const SignalGuard guard;
  ProgressLine line;
  using Clock = std::chrono::steady_clock;
  Clock::time_point due = Clock::now();  // when the figures are written next
  for (const Variant& variant : variants) {
    RunOptions each = options;
    each.out = out.path() / variant.name;
    each.name = fmt::format("run {} of {}", runs.size() + 1, variants.size());
    RunResult result = variant.run(each);
    worst = std::max(worst, result.summary.exit_code());
    runs.emplace_back(variant.name, std::move(result.summary));
    if (result.report && reports.size() < kReported) reports.push_back(std::move(*result.report));
    if (SignalGuard::caught() != 0) worst = std::max(worst, 128 + SignalGuard::caught());
    // The figures are written after each run in case the next one is killed, but writing takes at most a
    // tenth of the time.
    const Clock::time_point now = Clock::now();
    if (now >= due || worst >= kOutputFailed || runs.size() == variants.size()) {
      worst =
          std::max(worst, TryToWrite([&] { Summary::WriteComparison(runs, out.path() / "summary.json"); }));
      due = now + 10 * (Clock::now() - now);
    }
    if (worst >= kOutputFailed) break;
    if (!line.terminal() && line.due()) line.Show({}, each.name);
  }
  for (std::size_t i = 0; i < reports.size(); ++i) report.Add(runs[i].first, reports[i]);
  worst = std::max(worst, TryToWrite([&] { report.Write(out.path() / "report.html"); }));
  Summary::PrintComparison(runs);
  PrintReportPath(out.path());
  return worst;
}

}  // namespace tenon::apps
