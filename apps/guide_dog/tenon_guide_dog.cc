// tenon-guide-dog: a quadruped that leads a person on a leash.

#include <fmt/core.h>

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/progress.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/controllers/legged/evaluation/walk_view.h>
#include <tenon/systems/framework/diagram_builder.h>

namespace tenon::apps {
namespace {

int RunOnce(const CommonArguments& arguments, const GuideDogScenario& scenario) {
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
  simulator.AddLog(Hz(1000), judged, {leash, walk, std::make_shared<ProgressSink>(duration)});
  signals.insert(signals.end(), faults.begin(), faults.end());

  const auto judge = [&](Summary& summary) {
    summary.Set("robot", scenario.robot);
    summary.Set("observer", std::string(EnumName(scenario.observer)));
    leash->AddTo(summary);
    walk->AddTo(summary);
  };
  const std::string description =
      fmt::format("{}, {:.4g} s, seed {}", scenario.robot, duration, scenario.seed);
  const Summary summary =
      RunAndWrite(arguments, scenario, duration, simulator, ScenarioReport(scenario, description), signals,
                  {&loop.world.plant.geometry, &loop.view.geometry, &loop.person.geometry,
                   &loop.leash.geometry, &loop.obstacles.geometry},
                  judge)
          .summary;
  summary.Print();
  return summary.exit_code();
}

int Run(const CommonArguments& arguments) {
  if (arguments.list) {
    ListScenarios("tenon-guide-dog");
    return kRan;
  }
  const YamlDocument document = LoadScenario(arguments, "tenon-guide-dog");
  auto scenario = document.Read<GuideDogScenario>();
  if (arguments.seed) scenario.seed = *arguments.seed;
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunBlaming(document, [&] { return RunOnce(arguments, scenario); });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Lets a quadruped lead a person on a leash and reports how well it did.", "tenon-guide-dog");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments); });
}
