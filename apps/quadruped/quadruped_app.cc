#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

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
  return Compare(options, ScenarioReport(scenario, Describe(scenario, Duration(scenario))), variants);
}

int RunSweep(const RunOptions& options, const QuadrupedScenario& scenario) {
  std::vector<Variant> variants;
  for (const auto& [name, run] : SweepOf(scenario)) variants.push_back(MakeVariant(name, run));
  return Compare(options, ScenarioReport(scenario, Describe(scenario, Duration(scenario))), variants);
}

/// Sets gait, speed and observer of the command line in the scenario.
void SetWalk(const WalkArguments& walk, const std::string& name, YamlDocument& document) {
  const auto scenario = document.Read<QuadrupedScenario>();
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("'{}' does not walk: remove --gait, --speed, --observer and --compare, or choose a "
                    "scenario that walks",
                    name));
  if (!walk.observer.empty()) document.Set("observer", walk.observer);
  for (std::size_t i = 0; i < scenario.walk->path.segments.size(); ++i) {
    const WalkSegment& segment = scenario.walk->path.segments[i];
    const std::string key = fmt::format("walk.path.segments.{}", i);
    if (segment.gait == Gait::kStand) continue;
    if (!walk.gait.empty()) document.Set(key + ".gait", walk.gait);
    if (walk.speed && segment.forward != 0)
      document.Set(key + ".forward_m_per_s", fmt::format("{}", *walk.speed));
  }
}

}  // namespace

int RunWalkCommand(YamlDocument document, const std::string& name, const WalkArguments& walk,
                   std::optional<double> duration, const RunOptions& options) {
  if (walk.any()) SetWalk(walk, name, document);
  auto scenario = document.Read<QuadrupedScenario>();
  if (duration) scenario.duration_s = *duration;
  return RunBlaming(document, [&] {
    if (!options.live && scenario.walk)
      CheckJudged(scenario.walk->judged_from_s, Duration(scenario), duration.has_value());
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

}  // namespace tenon::apps
