#include <tenon/apps/common/comparison.h>

#include <algorithm>
#include <filesystem>

namespace tenon::apps {

int Compare(const CommonArguments& arguments, Report report, const std::vector<Variant>& variants) {
  const std::filesystem::path base =
      arguments.out.empty() ? std::filesystem::path("out") / std::filesystem::path(arguments.scenario).stem()
                            : std::filesystem::path(arguments.out);
  Summary::Named runs;
  std::vector<Report> reports;
  int worst = kRan;
  for (const Variant& variant : variants) {
    CommonArguments each = arguments;
    each.out = (base / variant.name).string();
    RunResult result = variant.run(each);
    worst = std::max<int>(worst, result.summary.exit_code());
    runs.emplace_back(variant.name, std::move(result.summary));
    if (reports.size() < kReported) reports.push_back(std::move(result.report));
    Summary::WriteComparison(runs,
                             base / "summary.json");  // after each: nothing is lost if the next is killed
  }
  for (std::size_t i = 0; i < reports.size(); ++i) report.Add(runs[i].first, reports[i]);
  report.Write(base / "report.html");
  Summary::PrintComparison(runs);
  return worst;
}

}  // namespace tenon::apps
