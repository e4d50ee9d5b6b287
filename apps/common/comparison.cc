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
          "the variant '{}' cannot name a directory below --out: use at most 200 bytes, no '/', and no "
          "'.' at the beginning",
          internal::Excerpt(name)));
    }
    if (name == "summary.json" || name == "report.html")
      throw ParameterError(
          fmt::format("the variant '{}' has the name of an output file: choose another name", name));
    if (!seen.insert(name).second) {
      throw ParameterError(fmt::format("two variants have the name '{}': rename or remove one of them",
                                       internal::Excerpt(name)));
    }
  }
}

int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants) {
  std::vector<std::string> names;
  for (const Variant& variant : variants) names.push_back(variant.name);
  CheckVariantNames(names);
  const OutputDirectory out(options.out);
  for (const std::string& name : names)
    OutputDirectory(out.path() / name);  // also if a signal prevents its run
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
