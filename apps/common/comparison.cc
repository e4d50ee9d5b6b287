#include <tenon/apps/common/comparison.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/excerpt.h>

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <string_view>
#include <utility>

namespace tenon::apps {

void CheckVariantNames(const std::vector<std::string>& names) {
  std::set<std::string_view> seen;
  for (const std::string& name : names) {
    if (!IsVariantName(name)) {
      throw ParameterError(fmt::format(
          "the variant '{}' is to be a directory below --out: name it without '/', not with a '.' "
          "first, in 200 bytes",
          internal::Excerpt(name)));
    }
    if (name == "summary.json" || name == "report.html")
      throw ParameterError(
          fmt::format("the variant '{}' is called as a file of the whole: give it another name", name));
    if (!seen.insert(name).second) {
      throw ParameterError(
          fmt::format("two variants are called '{}': give each a name of its own, or take one out",
                      internal::Excerpt(name)));
    }
  }
}

int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants) {
  std::vector<std::string> names;
  for (const Variant& variant : variants) names.push_back(variant.name);
  CheckVariantNames(names);
  const OutputDirectory out(options.out);
  for (const std::string& name : names) OutputDirectory(out.path() / name);  // also of those that are not run
  Summary::Named runs;
  std::vector<Report> reports;
  int worst = kRan;
  const SignalGuard guard;
  ProgressLine line;
  using Clock = std::chrono::steady_clock;
  Clock::time_point due = Clock::now();  // when the figures are written again
  for (const Variant& variant : variants) {
    RunOptions each = options;
    each.out = out.path() / variant.name;
    each.name = fmt::format("run {} of {}", runs.size() + 1, variants.size());
    RunResult result = variant.run(each);
    worst = std::max(worst, result.summary.exit_code());
    runs.emplace_back(variant.name, std::move(result.summary));
    if (result.report && reports.size() < kReported) reports.push_back(std::move(*result.report));
    if (SignalGuard::caught() != 0) worst = std::max(worst, 128 + SignalGuard::caught());
    // After each, so that nothing is lost if the next is killed, but of many short ones no more than a tenth
    // of the time.
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
