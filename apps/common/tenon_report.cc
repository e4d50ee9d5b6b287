// tenon-report: writes one report of several existing runs.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/report/report.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

/// Returns the names of the runs in the report: the names of their directories or, if two are equal, the
/// given paths.
std::vector<std::string> NamesOf(const std::vector<std::string>& directories) {
  std::vector<std::string> names;
  for (const fs::path directory : directories)
    names.push_back(fs::absolute(directory / "").lexically_normal().parent_path().filename());
  std::vector<std::string> sorted = names;
  std::ranges::sort(sorted);
  return std::ranges::adjacent_find(sorted) == sorted.end() ? names : directories;
}

int Run(const std::vector<std::string>& directories, const fs::path& out) {
  if (directories.size() > kReported) {
    throw ParameterError(
        fmt::format("{} runs are too many: a report shows at most {}", directories.size(), kReported));
  }
  for (const std::string& directory : directories) {
    std::error_code ignored;
    if (fs::equivalent(directory, out, ignored)) {
      throw ParameterError(fmt::format(
          "--out '{}' is one of the runs and its report would be overwritten: choose another directory",
          out.string()));
    }
  }
  const std::vector<std::string> names = NamesOf(directories);
  std::vector<Report> runs;
  std::vector<Plot> plots;  // of all runs, without duplicates
  std::vector<std::string> titles;
  for (const std::string& directory : directories) {
    const ReportParams& params = runs.emplace_back(Report::Read(directory)).params();
    for (const Plot& plot : params.plots) {
      const auto same = [&](const Plot& other) {
        return other.title == plot.title && other.group == plot.group;
      };
      if (std::ranges::none_of(plots, same)) plots.push_back(plot);
    }
    if (std::ranges::find(titles, params.title) == titles.end()) titles.push_back(params.title);
  }
  Report report({.title = titles.size() == 1 ? titles.front() : fmt::format("{}", fmt::join(names, ", ")),
                 .description = fmt::format("{}", fmt::join(titles.size() == 1 ? names : titles, "; ")),
                 .plots = plots});
  for (std::size_t i = 0; i < runs.size(); ++i) report.Add(names[i], runs[i]);
  const OutputLock lock(out);
  report.Write(out / "report.html");
  fmt::print("{}\n", (out / "report.html").string());
  return kRan;
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Compares runs of any app in one report.", "tenon-report");
  std::vector<std::string> directories;
  std::string out = "out/report";
  app.add_option("DIR", directories, "output directories of runs")->required();
  app.add_option("--out", out, "directory for report.html (default: out/report)");
  app.footer(
      "Reads report.html and signals.csv of each run.\n"
      "    tenon-cdpr D2 --out out/soft --set pd.stiffness_N_per_m=3000 --controller pd\n"
      "    tenon-cdpr D2 --out out/stiff --set pd.stiffness_N_per_m=9000 --controller pd\n"
      "    tenon-report out/soft out/stiff\n"
      "Exit codes: 0 written; 2 invalid usage, or a directory without a run; 5 a file could not be written.");
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(directories, out); });
}
