#include <tenon/apps/guide_dog/guide_dog_run.h>

#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tenon/apps/common/blame.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/controllers/legged/evaluation/walk_view.h>
#include <tenon/systems/framework/diagram_builder.h>

namespace tenon::apps {

RunResult RunGuideDog(const GuideDogScenario& scenario, const RunOptions& options) {
  const double duration = Duration(scenario);

  DiagramBuilder builder;
  auto& loop =
      Blame("", [&]() -> GuideDog& { return builder.Add<GuideDog>("loop", MakeGuideDogParams(scenario)); });
  const std::vector<const Source*> faults = InsertFaults(builder, loop, scenario.faults);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, MakeSimulatorOptions(scenario));
  std::vector<const Source*> signals = GuideDogFigures::Signals(loop);
  const auto leash =
      std::make_shared<GuideDogFigures>(scenario.admittance.desired_tension, scenario.supervisor.threshold);
  const auto walk = std::make_shared<WalkFigures>();
  std::vector<const Source*> judged = signals;
  judged.push_back(WalkFigures::Solves(loop.locomotion));
  simulator.AddLog(Hz(1000), judged, {leash, walk});
  signals.insert(signals.end(), faults.begin(), faults.end());

  const auto judge = [&](Summary& summary) {
    summary.Set("robot", scenario.robot);
    summary.Set("observer", std::string(EnumName(scenario.observer)));
    leash->AddTo(summary);
    walk->AddTo(summary);
  };
  const std::string description =
      fmt::format("{}, {:.4g} s, seed {}", scenario.robot, duration, scenario.seed);
  return RunScenario(options, scenario, description, duration, simulator, signals,
                     {&loop.world.plant.geometry, &loop.view.geometry, &loop.person.geometry,
                      &loop.leash.geometry, &loop.obstacles.geometry},
                     judge);
}

ScenarioApp GuideDogApp() {
  return MakeScenarioApp(
      "tenon-guide-dog", [](const YamlDocument& document) { return document.Read<GuideDogScenario>(); },
      MakeGuideDogParams, RunGuideDog);
}

}  // namespace tenon::apps
