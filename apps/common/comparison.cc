#include <tenon/apps/common/comparison.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <string_view>
#include <utility>

namespace tenon::apps {

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
