#include <tenon/apps/common/run_scenario.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/simulation/background_log.h>
#include <tenon/systems/text/nearest_name.h>

#include <fmt/format.h>

#include <algorithm>
#include <new>

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

}  // namespace tenon::apps
