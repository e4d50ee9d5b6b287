// tenon-robot: makes a robot that walks from a URDF.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/quadruped/quadruped_proposal.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/mesh_paths.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

namespace {

namespace fs = std::filesystem;

constexpr double kHeight = 260;  // height of the picture without margins [pixels]
constexpr double kMargin = 20;   // [pixels]

/// A view by its axes in B: right and up in the picture, and towards the viewer.
struct View {
  const char* name;
  Eigen::Vector3d right, up, towards;
};

/// Draws the robot in its nominal stance as SVG: from the left, from the front and from above, to one scale,
/// with a scale bar of 0.1 m. Trunk, links and feet are plain shapes.
std::string DrawQuadruped(const QuadrupedDescription& robot) {
  const View views[] = {
      {"left", -Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()},
      {"front", Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()},
      {"above", -Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  std::array<std::array<Eigen::Vector3d, 4>, kNumLegs> legs;
  Eigen::AlignedBox3d box, trunk;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const LegPose pose = robot.PoseOfLeg(leg, robot.stance);
    legs[static_cast<std::size_t>(leg)] = {pose.p_BJ[0], pose.p_BJ[1], pose.p_BJ[2], pose.foot_B};
    for (const Eigen::Vector3d& p : legs[static_cast<std::size_t>(leg)]) box.extend(p);
    trunk.extend(legs[static_cast<std::size_t>(leg)][0]);
  }
  const double radius = robot.foot_radius, thick = 0.06 * robot.LegLength(0);
  trunk.extend(Eigen::Vector3d(trunk.min() - Eigen::Vector3d(thick, 0, thick)));
  trunk.extend(Eigen::Vector3d(trunk.max() + Eigen::Vector3d(thick, 0, 2 * thick)));
  box.extend(trunk);
  const Eigen::Vector3d size = box.sizes() + Eigen::Vector3d::Constant(2 * radius);
  const double scale = kHeight / std::max(size.z(), size.y());  // pixels per metre

  std::string shapes;
  double x = kMargin;
  for (const View& view : views) {
    const auto extent = [&](const Eigen::Vector3d& axis) { return size.dot(axis.cwiseAbs()); };
    const Eigen::Vector2d origin(x + scale * extent(view.right) / 2, kMargin + kHeight / 2);
    const auto at = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
      const Eigen::Vector3d d = p - box.center();
      return origin + scale * Eigen::Vector2d(d.dot(view.right), -d.dot(view.up));
    };
    // Layers are drawn from the back to the front.
    std::vector<std::pair<double, std::string>> layers;
    for (const auto& leg : legs) {
      std::string line;
      for (const Eigen::Vector3d& p : leg) line += fmt::format(" {:.1f},{:.1f}", at(p)[0], at(p)[1]);
      const Eigen::Vector2d foot = at(leg[3]);
      const double depth = leg[3].dot(view.towards);
      const char* colour = depth < box.center().dot(view.towards) ? "#8aa1b8" : "#33556f";
      layers.emplace_back(
          depth, fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.1f}\" "
                             "stroke-linecap=\"round\" stroke-linejoin=\"round\"/>\n"
                             "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"#c0562b\"/>\n",
                             line.substr(1), colour, std::max(2.0, 1.2 * scale * radius), foot[0], foot[1],
                             scale * radius));
    }
    const Eigen::Vector2d low = at(trunk.min()), high = at(trunk.max());
    layers.emplace_back(
        box.center().dot(view.towards),
        fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"6\" "
                    "fill=\"#d7dee5\" stroke=\"#33556f\"/>\n",
                    std::min(low[0], high[0]), std::min(low[1], high[1]), std::abs(high[0] - low[0]),
                    std::abs(high[1] - low[1])));
    std::stable_sort(layers.begin(), layers.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& layer : layers) shapes += layer.second;
    shapes += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", origin[0],
                          kHeight + 2 * kMargin + 14, view.name);
    x += scale * extent(view.right) + 2 * kMargin;
  }
  const double width = x - kMargin, height = kHeight + 2 * kMargin + 24;
  shapes += fmt::format(
      "<path d=\"M {0:.1f} {1:.1f} h {2:.1f}\" stroke=\"#000\" stroke-width=\"3\"/>\n"
      "<text x=\"{3:.1f}\" y=\"{4:.1f}\">0.1 m</text>\n",
      kMargin, height - 8, 0.1 * scale, kMargin, height - 14);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"13\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{2}</svg>\n",
      width, height, shapes);
}

/// The command line of tenon-robot.
struct RobotArguments {
  std::string urdf;                ///< URDF file of a quadruped
  std::string out;                 ///< output directory; empty: out/NAME
  std::vector<std::string> locks;  ///< fixed joints as JOINT=ANGLE [rad]
  std::string forward;             ///< axis along which the robot faces: x, y, z, -x, -y or -z; empty: found
  std::string up;                  ///< axis that points up, likewise
  std::optional<double> mass;      ///< of the robot, shared by the bodies without mass in the URDF [kg]
  bool strict = false;             ///< refuse impossible inertias instead of correcting them
};

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

/// Returns the name of a robot's file without .urdf, .xacro or .urdf.xacro.
std::string NameOf(const fs::path& file) {
  const fs::path stem = file.stem();
  return (stem.extension() == ".urdf" ? stem.stem() : stem).string();
}

/// Expands a xacro file into a URDF in `out`, which it locks, if xacro is installed. Returns the file itself
/// otherwise, and if it is a URDF. Beside the file the URDF has a name of its own.
fs::path Expanded(const fs::path& file, const fs::path& out, std::optional<OutputLock>& lock) {
  if (ReadText(file).find("<xacro:") == std::string::npos) return file;
  lock.emplace(out);
  const std::string name = NameOf(file);
  std::error_code error;
  fs::path urdf = out / (name + ".urdf");
  if (fs::equivalent(file, urdf, error) || fs::equivalent(fs::absolute(file).parent_path(), out, error))
    urdf = out / (name + "_expanded.urdf");
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

/// Writes the YAML file and a picture of the robot in a URDF, then simulates it standing and trotting.
/// Returns the exit code of the last simulation. Throws ParameterError, and the errors of the outputs.
int ProposeRobot(const RobotArguments& arguments) {
  const fs::path given = arguments.urdf;
  const fs::path out = arguments.out.empty() ? fs::path("out") / NameOf(given) : fs::path(arguments.out);
  std::optional<OutputLock> lock;
  const fs::path urdf = Expanded(given, out, lock);
  const std::string name = urdf.stem().string();
  const UrdfLegsOptions options{.locked = LockedJoints(arguments.locks),
                                .forward = AxisOf("--forward", arguments.forward),
                                .up = AxisOf("--up", arguments.up)};
  if (options.forward && options.up &&
      internal::Along(*options.forward).dot(internal::Along(*options.up)) != 0)
    throw ParameterError(fmt::format("--up {}: the axis must be at right angles to --forward {}",
                                     arguments.up, arguments.forward));
  const QuadrupedProposal proposal = ProposeQuadruped(urdf, options, arguments.strict, arguments.mass);

  if (!lock) lock.emplace(out);
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

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line("Makes a robot's YAML file from its URDF, draws it, lets it stand and trot.",
                   "tenon-robot");
  RobotArguments arguments;
  line.Add("URDF", &arguments.urdf, "URDF of a quadruped with three joints per leg, see docs/robots.md",
           {.required = true});
  line.Add("--out", &arguments.out,
           "directory for NAME.yaml, the URDF, NAME.svg and the trial runs (default: out/NAME)");
  line.Add("--lock", &arguments.locks, "a joint to fix, and its angle [rad or m]: --lock arm_1=0.5",
           {.type = "JOINT=ANGLE", .one_value_each = true});
  line.Add("--forward", &arguments.forward,
           "axis of the trunk's link along which the robot faces: x, y, z, -x, -y or -z (default: found from "
           "joints and names)");
  line.Add("--up", &arguments.up, "axis of the trunk's link that points up, likewise");
  line.Add("--mass", &arguments.mass,
           "mass of the robot, shared by the bodies without mass by the volume of their shapes [kg]");
  line.Add("--strict", &arguments.strict,
           "refuse inertias that no body can have, instead of correcting them");
  line.SetFooter(
      "Exit codes: 0 the robot trots; 2 bad usage or URDF; 3 it fell or exceeded physical limits; 4 "
      "numerical failure; 5 a file could not be written; 130, 143 stopped by Ctrl-C, SIGTERM.");
  return RunMain(line, argc, argv, [&] { return ProposeRobot(arguments); });
}
