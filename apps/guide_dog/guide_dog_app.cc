#include <tenon/apps/common/faults.h>
#include <tenon/apps/guide_dog/guide_dog_app.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

namespace tenon::apps {
namespace {

/// Lets a browser drag the person to a goal, to which the person walks at kSpeed.
LiveControls::Goal PersonGoalOf(const Person& person) {
  constexpr double kReach = 20;   // largest distance of the goal from the start, along each axis [m]
  constexpr double kSpeed = 0.5;  // [m/s]
  const Vec<2>& start = CurrentAs<LeafSystem<PersonParams>>(person).params.start;
  return {"person",
          {Vec<3>(start[0] - kReach, start[1] - kReach, 0), Vec<3>(start[0] + kReach, start[1] + kReach, 0)},
          [&person](Context&, const Vec<3>& place) {
            return LiveSets{SetTo(person.goal, {true, place.head<2>(), kSpeed})};
          }};
}

RunResult RunGuideDog(const GuideDogScenario& scenario, const RunOptions& options,
                      const Customisation<GuideDog>& customisation) {
  const double duration = Duration(scenario);
  const SizeRatio ratio = RatioOf(scenario);
  if (!options.live && !options.out.empty()) CheckJudged(scenario.walk.judged_from_s, duration, true);

  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  const GuideDogParams params = Blame("", [&] { return MakeGuideDogParams(scenario); });
  const ObserverKind observer = params.observer.kind;
  auto& loop = AddDiagram(
      builder, [&] { return params; }, customisation, scenario, outputs, faults);
  CheckObserver(scenario.observer, loop);
  std::optional<QuadrupedLive> live;
  if (options.live) Blame("forces", [&] { live.emplace(builder, loop.world, &loop.walk, scenario.live); });
  Ros2Outputs ros2(builder, options);
  AddRos2(builder, ros2, scenario, loop, live ? live->drive() : nullptr);
  const OutputPort<Geometry>* footholds =
      options.live || !options.out.empty() ? AddLegErrors(builder, loop) : nullptr;
  const auto diagram = builder.Build();
  SimulatorOptions simulation = MakeSimulatorOptions(scenario, loop.world.plant);
  if (options.ros2 && !options.live) simulation.real_time_rate = 1;
  Simulator simulator(*diagram, simulation);
  std::vector<const Source*> signals = GuideDogFigures::Signals(loop);
  const auto leash =
      std::make_shared<GuideDogFigures>(loop, options.live ? std::nullopt : std::optional(scenario.task));
  const auto walk =
      std::make_shared<WalkFigures>(loop, scenario.walk.judged_from_s, observer != ObserverKind::kNone,
                                    MakePathVerdict(scenario.walk, options.live != nullptr));
  simulator.AddLog(Hz(1000), GuideDogFigures::Judged(loop), {leash, walk});
  const auto limits = std::make_shared<LimitFigures>(loop.world.plant);
  simulator.AddLog(Hz(1000), LimitFigures::Signals(loop.world.plant), {InBackground(limits)});
  const auto collisions = std::make_shared<CollisionFigures>(loop);
  simulator.AddLog(Hz(1000), CollisionFigures::Signals(loop), {InBackground(collisions)});
  outputs.AddTo(simulator);
  signals.insert(signals.end(), faults.begin(), faults.end());

  const auto judge = [&](Summary& summary) {
    summary.Set("robot", ResourceName(scenario.robot));
    summary.Set("observer", IsReplaced(loop.observer) ? kMine : EnumName(observer));
    leash->AddTo(summary);
    walk->AddTo(summary);
    limits->AddTo(summary);
    collisions->AddTo(summary);
    ros2.AddTo(summary, simulator);
    outputs.AddTo(summary);
    if (!options.live) scenario.task.AddTo(summary, 0, ratio.weight, ratio.length);
  };
  std::vector<const OutputPort<Geometry>*> shapes = GuideDogFigures::Shapes(loop);
  LiveControls controls;
  if (live) {
    live->AddTo(signals, shapes);
    controls = live->Controls();
    if (FindCurrent(loop.person.goal) != nullptr) controls.goal = PersonGoalOf(loop.person);
  }
  if (footholds != nullptr) shapes.push_back(footholds);
  outputs.AddTo(signals, shapes);
  return RunScenario(options, scenario, Describe(scenario, duration), duration, simulator, signals, shapes,
                     DriveLimits(loop.world.plant), judge, controls, outputs.plots());
}

}  // namespace

ScenarioApp GuideDogApp::AsScenarioApp() const {
  const auto read = [](const YamlDocument& document, const Customisation<GuideDog>& customisation) {
    auto scenario = customisation.ReadScenario<GuideDogScenario>(document);
    CheckJudged(scenario.walk.judged_from_s, Duration(scenario));
    return scenario;
  };
  const auto check = [](const GuideDogScenario& scenario, const Customisation<GuideDog>& customisation) {
    DiagramBuilder builder;
    Outputs outputs(builder);
    std::vector<const Source*> faults;
    const auto params = [&] { return MakeGuideDogParams(scenario); };
    CheckObserver(scenario.observer, AddDiagram(builder, params, customisation, scenario, outputs, faults));
  };
  ScenarioApp app =
      MakeApp("tenon-guide-dog", "Lets a quadruped lead a person on a leash and reports how well it did.",
              LeggedFiles(), read, check, RunGuideDog);
  app.warnings = [](const YamlDocument& document) {
    return RunBlaming(document, [&] {
      const auto scenario = document.Read<GuideDogScenario>();
      return Blame("robot", [&] { return QuadrupedWarnings(scenario.robot); });
    });
  };
  return app;
}

/// The main function of tenon-guide-dog.
int GuideDogMain(int argc, char** argv) {
  return GuideDogApp().Run(argc, argv);
}

}  // namespace tenon::apps
