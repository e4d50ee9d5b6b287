// tenon-quadruped: a quadruped that stands, drops, or walks.

#include <fmt/core.h>

#include "tenon/apps/common/command_line.h"
#include "tenon/apps/common/outputs.h"
#include "tenon/apps/common/progress.h"
#include "tenon/apps/quadruped_scenario.h"
#include "tenon/apps/stand_figures.h"
#include "tenon/apps/walk_figures.h"

namespace tenon::apps {
namespace {

/// What the command line may say of a walk.
struct WalkArguments {
  std::string gait;
  std::optional<double> speed;
};

/// One run of a diagram, into the directory of `arguments`.
template <class Loop, class Figures>
ExitCode RunOnce(const CommonArguments& arguments, const QuadrupedScenario& scenario, const auto& params) {
  DiagramBuilder builder;
  auto& loop = builder.Add<Loop>("loop", params);
  const auto diagram = builder.Build();
  const double duration = Duration(scenario);
  Report report({.title = fmt::format("{}: {}", scenario.case_name, scenario.description),
                 .description = fmt::format("{}, {:.4g} s, seed {}", scenario.robot, duration, scenario.seed),
                 .plots = scenario.report.plots,
                 .events = scenario.report.events,
                 .signal_rate = Hz(scenario.log_rate_hz)});

  Simulator simulator(*diagram, MakeSimulatorOptions(scenario));
  const std::vector<const Source*> signals = Figures::Signals(loop);
  report.Log(simulator, signals, {&loop.world.plant.geometry});

  const OutputDirectory out(arguments, WriteYaml(scenario));
  out.WriteGraph(*diagram);
  const auto figures = std::make_shared<Figures>();
  simulator.AddLog(Hz(1000), signals, {figures, std::make_shared<ProgressSink>(duration)});
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, {std::make_shared<CsvLog>(out.path() / "signals.csv")});
  const RunOutcome outcome = Advance(simulator, duration);

  Summary summary(scenario.case_name, scenario.seed, outcome);
  summary.Set("robot", scenario.robot);
  figures->AddTo(summary);
  summary.Set("evaluations", static_cast<double>(simulator.statistics().evaluations));
  summary.Write(out.path() / "summary.json");
  summary.AddTo(report);
  report.Write(out.path() / "report.html");
  summary.Print();
  return summary.exit_code();
}

/// The scenario, of which every segment that walks gets the gait and, forwards, the speed of the command
/// line.
QuadrupedScenario ReadScenario(const CommonArguments& arguments, const WalkArguments& walk) {
  YamlDocument document = LoadScenario(arguments);
  const auto scenario = document.Read<QuadrupedScenario>();
  if (walk.gait.empty() && !walk.speed) return scenario;
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("'{}' does not walk: leave --gait and --speed away, or take a scenario that does",
                    arguments.scenario));
  for (std::size_t i = 0; i < scenario.walk->path.segments.size(); ++i) {
    const WalkSegment& segment = scenario.walk->path.segments[i];
    const std::string key = fmt::format("walk.path.segments.{}", i);
    if (segment.gait == Gait::kStand) continue;
    if (!walk.gait.empty()) document.Set(key + ".gait", walk.gait);
    if (walk.speed && segment.forward != 0)
      document.Set(key + ".forward_m_per_s", fmt::format("{}", *walk.speed));
  }
  return document.Read<QuadrupedScenario>();
}

int Run(const CommonArguments& arguments, const WalkArguments& walk) {
  if (arguments.list) {
    ListScenarios("tenon-quadruped");
    return kRan;
  }
  QuadrupedScenario scenario = ReadScenario(arguments, walk);
  if (arguments.seed) scenario.seed = *arguments.seed;
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  if (scenario.walk)
    return RunOnce<QuadrupedWalk, WalkFigures>(arguments, scenario, MakeWalkParams(scenario));
  return RunOnce<QuadrupedStand, StandFigures>(arguments, scenario, MakeStandParams(scenario));
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Lets a quadruped stand or walk and reports how well it did.", "tenon-quadruped");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  tenon::apps::WalkArguments walk;
  app.add_option("--gait", walk.gait, "crawl, trot, pace or gallop (the scenario's, unless given)");
  app.add_option("--speed", walk.speed, "forwards [m/s] (the scenario's, unless given)");
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments, walk); });
}
