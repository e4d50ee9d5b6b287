// tenon-quadruped: a quadruped that stands, drops, or walks.

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

/// What the command line may say of a walk.
struct WalkArguments {
  std::string gait;
  std::optional<double> speed;
  std::string observer;
  bool compare = false;

  bool any() const { return !gait.empty() || speed || !observer.empty() || compare; }
};

Variant MakeVariant(std::string name, const QuadrupedScenario& scenario) {
  return {std::move(name), [scenario](const RunOptions& each) { return RunQuadruped(scenario, each); }};
}

int CompareObservers(const RunOptions& options, QuadrupedScenario scenario) {
  std::vector<ObserverKind> kinds = scenario.compare;
  if (kinds.empty())
    for (const auto& [kind, name] : EnumNames(ObserverKind{})) kinds.push_back(kind);
  std::vector<Variant> variants;
  for (const ObserverKind kind : kinds) {
    scenario.observer = kind;
    variants.push_back(MakeVariant(EnumName(kind), scenario));
  }
  return Compare(options, ScenarioReport(scenario, Describe(scenario)), variants);
}

int RunSweep(const RunOptions& options, const QuadrupedScenario& scenario) {
  std::vector<Variant> variants;
  for (const auto& [name, run] : SweepOf(scenario)) variants.push_back(MakeVariant(name, run));
  return Compare(options, ScenarioReport(scenario, Describe(scenario)), variants);
}

/// The scenario with what the command line says of its walk: every segment that walks gets the gait and,
/// forwards, the speed.
YamlDocument LoadWalk(const CommonArguments& arguments, const WalkArguments& walk) {
  YamlDocument document = LoadScenario(arguments, "tenon-quadruped");
  if (!walk.any()) return document;
  const auto scenario = document.Read<QuadrupedScenario>();
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("'{}' does not walk: leave --gait, --speed, --observer and --compare away, or take a "
                    "scenario that does",
                    arguments.scenario));
  if (!walk.observer.empty()) document.Set("observer", walk.observer);
  for (std::size_t i = 0; i < scenario.walk->path.segments.size(); ++i) {
    const WalkSegment& segment = scenario.walk->path.segments[i];
    const std::string key = fmt::format("walk.path.segments.{}", i);
    if (segment.gait == Gait::kStand) continue;
    if (!walk.gait.empty()) document.Set(key + ".gait", walk.gait);
    if (walk.speed && segment.forward != 0)
      document.Set(key + ".forward_m_per_s", fmt::format("{}", *walk.speed));
  }
  return document;
}

int RunOnce(const CommonArguments& arguments, const WalkArguments& walk, const RunOptions& options) {
  const YamlDocument document = LoadWalk(arguments, walk);
  auto scenario = document.Read<QuadrupedScenario>();
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunBlaming(document, [&] {
    if (!options.live && scenario.walk)
      CheckJudged(scenario.walk->judged_from_s, Duration(scenario), arguments.duration.has_value());
    if (options.live && scenario.sweep)
      throw KeyError("sweep", "--live and --replay run one scenario: set sweep to null");
    for (const std::string& warning : Blame("robot", [&] { return QuadrupedWarnings(scenario.robot); }))
      Say(fmt::format("warning: {}\n", warning));
    if (walk.compare && scenario.sweep)
      throw KeyError("sweep", "--compare runs the scenario once with each observer: set sweep to null");
    if (walk.compare) return CompareObservers(options, scenario);
    if (scenario.sweep) return RunSweep(options, scenario);
    return PrintResult(RunQuadruped(scenario, options).summary, options);
  });
}

int Run(const CommonArguments& arguments, const WalkArguments& walk) {
  if (PrintsInstead(arguments, QuadrupedApp())) return kRan;
  if (walk.compare && (!arguments.live.empty() || !arguments.replay.empty()))
    throw ParameterError("--live and --replay run one scenario: leave --compare away");
  return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
    return RunOnce(now, walk, options);
  });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app(tenon::apps::QuadrupedApp().description, "tenon-quadruped");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  tenon::apps::AddLiveArguments(app, arguments);
  tenon::apps::WalkArguments walk;
  app.add_option("--gait", walk.gait, "crawl, trot, pace or gallop (the scenario's, unless given)");
  app.add_option("--speed", walk.speed, "forwards [m/s] (the scenario's, unless given)");
  app.add_option("--observer", walk.observer,
                 "none, legs, com, hybrid, focchi, ndo_m or ndo_inverse (the scenario's, unless given)");
  app.add_flag("--compare", walk.compare,
               "one run per observer, each in a directory of its own below --out, and one report of all")
      ->excludes("--observer");
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments, walk); });
}
