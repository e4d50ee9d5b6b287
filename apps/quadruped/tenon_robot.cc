// tenon-robot: from a URDF to a robot that walks.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/read_text.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_proposal.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/robot_drawing.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/parse_number.h>
#include <tenon/systems/yaml/mesh_paths.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kStand = 3;  // [s]
constexpr double kTrot = 10;

struct RobotArguments {
  std::string urdf, out;
  std::vector<std::string> locks;  ///< JOINT=ANGLE
};

std::map<std::string, double, std::less<>> LockedJoints(const std::vector<std::string>& locks) {
  std::map<std::string, double, std::less<>> angles;
  for (const std::string& lock : locks) {
    const std::size_t equals = lock.find('=');
    const std::string text = equals == std::string::npos ? "" : lock.substr(equals + 1);
    const auto angle = internal::NumberIn<double>(internal::WithoutPlus(text));
    if (!angle || !std::isfinite(*angle))
      throw ParameterError(fmt::format("--lock {}: write JOINT=ANGLE, the angle in rad", lock));
    angles[lock.substr(0, equals)] = *angle;
  }
  return angles;
}

/// A shipped scenario with this robot; what it leaves in a directory of its own.
Summary Try(const char* scenario, const fs::path& yaml, double duration, const fs::path& out) {
  const YamlDocument document = LoadScenario(scenario, {"robot=" + yaml.string()}, "tenon-quadruped");
  return QuadrupedApp().run(document, duration, {.out = out}).summary;
}

/// What a trial says of the robot: nothing, if it was stopped or its files could not be written.
std::string Shown(const Summary& trial, const char* name) {
  const int code = trial.exit_code();
  if (code == kRan) return "yes";
  if (code >= kOutputFailed)
    return fmt::format("not known: the trial {}",
                       code == kOutputFailed ? "could not be written" : "was stopped");
  return fmt::format("no, see {}/report.html", name);
}

int Run(const RobotArguments& arguments) {
  const fs::path urdf = arguments.urdf;
  const std::string name = urdf.stem().string();
  const fs::path out = arguments.out.empty() ? fs::path("out") / name : fs::path(arguments.out);
  const QuadrupedProposal proposal = ProposeQuadruped(urdf, LockedJoints(arguments.locks));

  const OutputLock lock(out);
  std::error_code error;
  const fs::path beside = out / urdf.filename(), yaml = out / (name + ".yaml");
  if (!fs::equivalent(urdf, beside, error)) {
    WriteFile(beside, WithMeshesFound(ReadText(urdf), urdf));
  }
  WriteFile(yaml, proposal.yaml);
  const QuadrupedDescription robot = LoadQuadruped(yaml.string());
  WriteFile(out / (name + ".svg"), DrawQuadruped(robot));

  fmt::print("{:<28} {}\n", "robot", yaml.string());
  fmt::print("{:<28} {}\n", "picture", (out / (name + ".svg")).string());
  fmt::print("{:<28} {:.4g}\n", "mass_kg", robot.mass());
  fmt::print("{:<28} {:.4g}\n", "leg_length_m", robot.LegLength(kFrontLeft));
  fmt::print("{:<28} {:.4g}\n", "stance_height_m", robot.StanceHeight());
  for (const std::string& note : proposal.notes) fmt::print("note: {}\n", note);
  std::fflush(stdout);

  const Summary stand = Try("stand", yaml, kStand, out / "stand");
  fmt::print("{:<28} {}\n", "stands", Shown(stand, "stand"));
  std::fflush(stdout);
  if (stand.exit_code() >= kOutputFailed) return stand.exit_code();
  const Summary trot = Try("flat", yaml, kTrot, out / "trot");
  fmt::print("{:<28} {}\n", "trots", Shown(trot, "trot"));
  NamedTexts figures;
  for (const auto& [key, value] : trot.Flat())
    if (key == "end_reason" || key == "com_error_max_m" || key.starts_with("foot_error_max_m"))
      figures.emplace_back(key, value);
  fmt::print("{}", FigureLines(FigureTexts(figures)));
  for (const char* trial : {"stand", "trot"}) PrintReportPath(out / trial);
  return trot.exit_code();
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Makes a robot's YAML file from its URDF, draws it, lets it stand and trot.", "tenon-robot");
  tenon::apps::RobotArguments arguments;
  app.add_option("URDF", arguments.urdf, "of a quadruped with three joints a leg; see docs/robots.md")
      ->required();
  app.add_option("--out", arguments.out,
                 "directory for NAME.yaml, the URDF, NAME.svg and the trial runs (default: out/NAME)");
  app.add_option("--lock", arguments.locks,
                 "a joint that is not to turn, and its angle [rad]: --lock arm_1=0.5")
      ->type_name("JOINT=ANGLE")
      ->allow_extra_args(false);
  app.footer(
      "Exit codes: 0 the robot trots; 2 bad usage or URDF; 3 it fell, or did what no robot can; 4 numerical "
      "failure; 5 a file could not be written; 130, 143 stopped by Ctrl-C, SIGTERM.");
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments); });
}
