// tenon-cdpr-workspace: proven workspaces of a cable robot, see docs/cdpr_workspace.md.

#include <tenon/apps/cdpr/workspace_study.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

/// Thrown to leave the study after Ctrl-C.
struct Interrupted {};

struct Arguments {
  std::string robot, out;
  std::vector<std::string> settings;
  std::vector<double> euler, low, high, position;  ///< three numbers each, or none
  WorkspaceStudyParams params;
};

std::optional<Eigen::Vector3d> Vector(const std::vector<double>& numbers) {
  if (numbers.empty()) return {};
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

int Run(Arguments arguments) {
  YamlDocument document = LoadResource("robots", YamlFile{arguments.robot}, "cables");
  ApplySettings(arguments.settings, &document);
  const auto robot = document.Read<CdprDescription>();
  WorkspaceStudyParams& params = arguments.params;
  params.euler = Vector(arguments.euler).value_or(Eigen::Vector3d::Zero());
  params.low = Vector(arguments.low);
  params.high = Vector(arguments.high);
  params.position = Vector(arguments.position);
  const OutputDirectory out(arguments.out.empty() ? "out/" + robot.name + "_workspace" : arguments.out);

  const SignalGuard guard;
  ProgressLine line;
  try {
    const WorkspaceStudy study = StudyWorkspace(robot, params, [&](const std::string& what, double share) {
      if (SignalGuard::caught() != 0) throw Interrupted();
      if (line.due())
        line.Show(share, fmt::format("{}: {:.0f} % of the box, {:.0f} s", what, 100 * share, line.elapsed()));
    });
    line.End(1, fmt::format("{:.1f} s", study.wall));
    NamedTexts figures;
    for (const auto& [name, value] : study.figures)
      figures.emplace_back(name, value ? fmt::format("{}", *value) : "");
    fmt::print("{}", FigureLines(FigureTexts(figures)));
    const int code = TryToWrite([&] { WriteWorkspaceStudy(study, out.path()); });
    PrintReportPath(out.path());
    return code;
  } catch (const Interrupted&) {
    Say("interrupted: nothing is written\n");
    return 128 + SignalGuard::caught();
  }
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line(
      "Computes the workspace of a cable robot. With six or more cables, three or more in a plane, proven "
      "cell "
      "by cell: positions at one attitude and attitudes at one position, at rest and with the required "
      "wrenches, and wrench closure; with fewer cables, positions with a stable equilibrium. With tension "
      "margins, stiffness and interference.",
      "tenon-cdpr-workspace");
  Arguments arguments;
  auto& params = arguments.params;
  const OptionTraits shown{.shows_default = true}, three{.count = 3};
  line.Add("ROBOT", &arguments.robot, "name of a shipped robot, or a YAML file", {.required = true});
  line.Add("--load", &params.demand.load, "mass at the platform's CoM [kg]", shown);
  line.Add("--acceleration", &params.demand.acceleration,
           "maximum acceleration of platform and load along each axis [m/s^2]", shown);
  line.Add("--force", &params.demand.force, "maximum external force along each axis [N]", shown);
  line.Add("--torque", &params.demand.torque, "maximum external torque about each axis [N m]", shown);
  line.Add("--attitude", &arguments.euler, "roll, pitch, yaw for the map of positions [rad] (default: level)",
           three);
  line.Add("--low", &arguments.low,
           "lower corner of the positions [m] (default: that of the anchors, down to the floor)", three);
  line.Add("--high", &arguments.high, "upper corner of the positions [m] (default: that of the anchors)",
           three);
  line.Add("--cell", &params.cell,
           "size of the smallest cells [m] (default: 1/48 of the longest edge, 1/24 for equilibria)");
  line.Add("--position", &arguments.position,
           "position for the map of attitudes [m] (default: the middle of the workspace)", three);
  line.Add("--turn", &params.turn, "range of the map of attitudes about each axis, either way [rad]", shown);
  line.Add("--cable-diameter", &params.cable_diameter, "distance below which two cables touch [m]", shown);
  line.Add("--set", &arguments.settings,
           "override a value of the robot: --set cable_properties.tension_max_N=2000",
           {.type = "KEY=VALUE", .one_value_each = true});
  line.Add("--out", &arguments.out, "directory for all output (default: out/ROBOT_workspace)");
  line.SetFooter(
      "Writes report.html, summary.json, cells.csv and attitudes.csv to the output directory.\n"
      "Exit codes: 0 ran; 2 bad usage or robot; 4 numerical failure; 5 a file could not be written; 130, 143 "
      "stopped by Ctrl-C, SIGTERM.");
  return RunMain(line, argc, argv, [&] { return Run(arguments); });
}
