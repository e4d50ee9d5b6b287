#include <tenon/apps/common/comparison.h>

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include <tenon/systems/framework/errors.h>

namespace tenon::apps {

void CheckVariantNames(const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (name.empty() || name.front() == '.' || name.find_first_of(std::string_view("/\0", 2)) != name.npos) {
      throw ParameterError(fmt::format(
          "the variant '{}' is to be a directory below --out: name it without '/' and not with a '.' first",
          name));
    }
    if (std::count(names.begin(), names.end(), name) > 1) {
      throw ParameterError(
          fmt::format("two variants are called '{}': give each a name of its own, or take one out", name));
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
  for (const Variant& variant : variants) {
    RunOptions each = options;
    each.out = out.path() / variant.name;
    RunResult result = variant.run(each);
    worst = std::max(worst, result.summary.exit_code());
    runs.emplace_back(variant.name, std::move(result.summary));
    if (result.report && reports.size() < kReported) reports.push_back(std::move(*result.report));
    // After each: nothing is lost if the next is killed.
    worst = std::max(worst, TryToWrite([&] { Summary::WriteComparison(runs, out.path() / "summary.json"); }));
    if (worst >= kOutputFailed) break;
  }
  for (std::size_t i = 0; i < reports.size(); ++i) report.Add(runs[i].first, reports[i]);
  worst = std::max(worst, TryToWrite([&] { report.Write(out.path() / "report.html"); }));
  Summary::PrintComparison(runs);
  return worst;
}

}  // namespace tenon::apps
