// tenon-report: writes one report of several existing runs, or pictures of one report.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/tenon_report.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

/// Returns the names of the runs in the report: the names of their directories or, if two are equal, the
/// given paths.
std::vector<std::string> NamesOf(const std::vector<std::string>& directories) {
  std::vector<std::string> names;
  for (const fs::path directory : directories)
    names.push_back(
        internal::Excerpt(fs::absolute(directory / "").lexically_normal().parent_path().filename().string()));
  std::vector<std::string> sorted = names;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) == sorted.end()) return names;
  std::ranges::transform(directories, names.begin(), internal::Printable);
  return names;
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
  using tenon::apps::OptionRange;
  tenon::apps::CommandLine line("Compares runs of any app in one report, or draws pictures of one report.",
                                "tenon-report");
  std::vector<std::string> directories;
  std::string out = "out/report";
  tenon::apps::ReportPictures pictures;
  line.Add("DIR", &directories,
           "output directories of runs; or one MCAP file; for pictures one report.html or its directory",
           {.required = true});
  line.Add("--out", &out, "directory for report.html (default: out/report)");
  line.Add("--svg", &pictures.svg, "write all plots, or the drawings of a campaign, to this directory");
  line.Add("--frame", &pictures.frame, "write the replay at this time [s] to this file, .svg or .png",
           {.type = "TIME FILE"});
  line.Add("--video", &pictures.video, "write the replay to this .webm file");
  line.Add("--frames", &pictures.frames, "write the replay as PNG files to this directory");
  line.Add("--size", &pictures.size, "WIDTHxHEIGHT of a picture [px] (default: 1280x720, of plots 600x300)");
  line.Add("--from", &pictures.from, "time at which the video begins [s]");
  line.Add("--to", &pictures.to, "time at which the video ends [s]");
  line.Add("--fps", &pictures.fps, "frames per second of the video (default: 30)",
           {.range = OptionRange::kPositive});
  line.Add("--speed", &pictures.speed, "seconds of the run per second of the video (default: 1)",
           {.range = OptionRange::kPositive});
  line.SetFooter(
      "Reads report.html and signals.csv of each run.\n"
      "    tenon-cdpr D2 --out out/soft --set pd.stiffness_N_per_m=3000 --controller pd\n"
      "    tenon-cdpr D2 --out out/stiff --set pd.stiffness_N_per_m=9000 --controller pd\n"
      "    tenon-report out/soft out/stiff\n"
      "An MCAP file of ROS 2, also of another program, becomes a report and signals.csv:\n"
      "    tenon-report run.mcap --out out/log\n"
      "Pictures are drawn by Chromium, which must be installed:\n"
      "    tenon-report out/D1 --svg figures\n"
      "    tenon-report out/D1 --video D1.webm --from 2 --to 6 --speed 0.5\n"
      "Exit codes: 0 written; 2 invalid usage, a directory without a run, or no Chromium; 5 a file could not "
      "be "
      "written; 130, 143 stopped by Ctrl-C, SIGTERM.");
  return tenon::apps::RunMain(line, argc, argv, [&] {
    using namespace tenon;
    const bool draw = pictures.any();
    if (draw && (directories.size() > 1 || line.Has("--out")))
      throw ParameterError("pictures are drawn of one report: give one DIR, without --out");
    if (!draw && (pictures.from || pictures.to || pictures.fps || pictures.speed || !pictures.size.empty()))
      throw ParameterError(
          "--size, --from, --to, --fps and --speed need --video, --frames, --frame or --svg");
    const bool is_mcap = std::filesystem::path(directories.front()).extension() == ".mcap";
    if (is_mcap && !draw && directories.size() == 1) return apps::ReportMcap(directories.front(), out);
    return draw ? apps::DrawPictures(directories.front(), pictures) : apps::Run(directories, out);
  });
}
