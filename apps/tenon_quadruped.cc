// tenon-quadruped: stands a quadruped on its feet.

#include <fmt/core.h>

#include "tenon/apps/common/command_line.h"
#include "tenon/apps/common/outputs.h"
#include "tenon/apps/common/progress.h"
#include "tenon/apps/quadruped_figures.h"
#include "tenon/apps/quadruped_scenario.h"

namespace tenon::apps {
namespace {

int RunOnce(const CommonArguments& arguments, const QuadrupedScenario& scenario) {
  DiagramBuilder builder;
  auto& loop = builder.Add<QuadrupedStand>("loop", MakeStandParams(scenario));
  const auto diagram = builder.Build();
  Report report(
      {.title = fmt::format("{}: {}", scenario.case_name, scenario.description),
       .description = fmt::format("{}, {} s, seed {}", scenario.robot, scenario.duration_s, scenario.seed),
       .plots = scenario.report.plots,
       .events = scenario.report.events,
       .signal_rate = Hz(scenario.log_rate_hz)});

  Simulator simulator(*diagram, MakeSimulatorOptions(scenario));
  const std::vector<const Source*> signals = StandFigures::Signals(loop);
  report.Log(simulator, signals, {&loop.plant.geometry});

  const OutputDirectory out(arguments, WriteYaml(scenario));
  out.WriteGraph(*diagram);
  const auto figures = std::make_shared<StandFigures>();
  simulator.AddLog(Hz(scenario.pd.rate_hz), signals,
                   {figures, std::make_shared<ProgressSink>(scenario.duration_s)});
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, {std::make_shared<CsvLog>(out.path() / "signals.csv")});
  const RunOutcome outcome = Advance(simulator, scenario.duration_s);

  Summary summary(scenario.case_name, scenario.seed, outcome);
  summary.Set("robot", scenario.robot);
  summary.Set("height_min_m", figures->height_min());
  summary.Set("height_end_m", figures->height_end());
  summary.Set("drift_m", figures->drift());
  summary.Set("tilt_max_rad", figures->tilt_max());
  summary.Set("torque_max_N_m", figures->torque_max());
  summary.Set("foot_force_max_N", figures->foot_force_max());
  summary.Set("evaluations", static_cast<double>(simulator.statistics().evaluations));
  summary.Write(out.path() / "summary.json");
  summary.AddTo(report);
  report.Write(out.path() / "report.html");
  summary.Print();
  return summary.exit_code();
}

int Run(const CommonArguments& arguments) {
  if (arguments.list) {
    ListScenarios("tenon-quadruped");
    return kRan;
  }
  auto scenario = LoadScenario(arguments).Read<QuadrupedScenario>();
  if (arguments.seed) scenario.seed = *arguments.seed;
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunOnce(arguments, scenario);
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Stands a quadruped on its feet and reports how well it did.", "tenon-quadruped");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments); });
}
