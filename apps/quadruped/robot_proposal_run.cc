#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/read_text.h>
#include <tenon/apps/common/run_program.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/quadruped/held_mass.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/quadruped/quadruped_proposal.h>
#include <tenon/apps/quadruped/robot_drawing.h>
#include <tenon/apps/quadruped/robot_proposal_run.h>
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
#include <string>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kStand = 3;  // duration of the trial on the spot [s]
constexpr double kTrot = 10;  // duration of the trial trot [s]

internal::LockedJoints LockedJoints(const std::vector<std::string>& locks) {
  internal::LockedJoints angles;
  for (const std::string& lock : locks) {
    const std::size_t equals = lock.find('=');
    const std::string text = equals == std::string::npos ? "" : lock.substr(equals + 1);
    const auto angle = internal::NumberIn<double>(internal::WithoutPlus(text));
    if (!angle || !std::isfinite(*angle))
      throw ParameterError(
          fmt::format("--lock {}: write JOINT=ANGLE, the angle in rad, or in m if the joint slides", lock));
    angles[lock.substr(0, equals)] = *angle;
  }
  return angles;
}

std::optional<internal::LinkAxis> AxisOf(const char* option, const std::string& text) {
  if (text.empty()) return {};
  for (const auto& [axis, name] : EnumNames(internal::LinkAxis{}))
    if (text == name) return axis;
  throw ParameterError(fmt::format("{} {}: write x, y, z, -x, -y or -z", option, text));
}

/// Expands a xacro file into a URDF in `out`, if xacro is installed. Returns the file itself otherwise, and
/// if it is a URDF.
fs::path Expanded(const fs::path& file, const fs::path& out) {
  if (ReadText(file).find("<xacro:") == std::string::npos) return file;
  const std::string name = file.stem().stem().string();
  std::error_code error;
  fs::path urdf = out / (name + ".urdf");
  if (fs::equivalent(file, urdf, error)) urdf = out / (name + "_expanded.urdf");
  fs::create_directories(out, error);
  const std::optional<int> code = RunProgram({"xacro", file.string(), "-o", urdf.string()});
  if (!code) return file;
  if (*code != 0)
    throw ParameterError(fmt::format(
        "{}: xacro failed with exit code {}; correct the file as its messages say", file.string(), *code));
  WriteFile(urdf, WithMeshesFound(ReadText(urdf), file));
  return urdf;
}

/// Runs a shipped scenario with this robot, and writes its outputs to `out`.
Summary Try(const char* scenario, const fs::path& yaml, double duration, const fs::path& out) {
  const YamlDocument document = LoadScenario(scenario, {"robot=" + yaml.string()}, "tenon-quadruped");
  return QuadrupedApp().AsScenarioApp().run(document, duration, {.out = out}).summary;
}

/// Describes the result of a trial in words; empty if it was stopped or its files could not be written.
std::string Shown(const Summary& trial, const char* name) {
  const int code = trial.exit_code();
  if (code == kRan) return "yes";
  if (code >= kOutputFailed)
    return fmt::format("unknown: the trial {}",
                       code == kOutputFailed ? "could not be written" : "was stopped");
  return fmt::format("no, see {}/report.html", name);
}

}  // namespace

int ProposeRobot(const RobotArguments& arguments) {
  const fs::path given = arguments.urdf,
                 out =
                     arguments.out.empty() ? fs::path("out") / given.stem().stem() : fs::path(arguments.out),
                 urdf = Expanded(given, out);
  const std::string name = urdf.stem().string();
  const UrdfLegsOptions options{.locked = LockedJoints(arguments.locks),
                                .forward = AxisOf("--forward", arguments.forward),
                                .up = AxisOf("--up", arguments.up)};
  if (options.forward && options.up &&
      internal::Along(*options.forward).dot(internal::Along(*options.up)) != 0)
    throw ParameterError(fmt::format("--up {}: the axis must be at right angles to --forward {}",
                                     arguments.up, arguments.forward));
  const QuadrupedProposal proposal = ProposeQuadruped(urdf, options, arguments.strict);

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
  const HeldMass held = HeldByTwoLegs(robot);
  if (held.mass < robot.mass()) fmt::print("note: {}\n", CannotHold(robot, held));
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

}  // namespace tenon::apps
