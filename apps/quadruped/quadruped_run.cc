#include <tenon/apps/common/faults.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/quadruped_live.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

namespace {

constexpr double kLying = -1;  // least height of a served robot, which may lie down [m]

/// Runs a scenario by a diagram of class Loop; `observer` is given for a walk. Figures are made of the
/// diagram and `judging`.
template <class Loop, class Figures>
RunResult RunLoop(const RunOptions& options, const QuadrupedScenario& scenario, const auto& params,
                  std::optional<ObserverKind> observer, const Customisation<Loop>& customisation,
                  const Wire& wire, const auto&... judging) {
  const double duration = Duration(scenario);
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  auto& loop = AddDiagram(
      builder, [&] { return params; }, customisation, scenario, outputs, faults);
  if constexpr (requires { loop.observer; }) {
    CheckObserver(scenario.observer, loop);
    JudgeFootStep(scenario, duration, loop, outputs);
  }
  std::optional<QuadrupedLive> live;
  if (options.live) {
    WalkSchedule* walk = nullptr;
    if constexpr (requires { loop.walk; }) walk = &loop.walk;
    Blame("forces", [&] { live.emplace(builder, loop.world, walk, scenario.live); });
  }
  Ros2Outputs ros2(builder, options);
  AddRos2(builder, ros2, scenario, loop, live ? live->drive() : nullptr);
  const OutputPort<Geometry>* footholds = nullptr;
  if constexpr (requires { loop.locomotion; })
    if (options.live || !options.out.empty()) footholds = AddLegErrors(builder, loop);
  Served served;
  if constexpr (std::is_same_v<Loop, QuadrupedStand>)
    if (wire.any()) served = Serve(wire, builder, loop, options.out);
  const auto diagram = builder.Build();
  SimulatorOptions simulation = MakeSimulatorOptions(scenario, loop.world.plant);
  if (!wire.where.empty() || (options.ros2 && !options.live)) simulation.real_time_rate = 1;
  Simulator simulator(*diagram, simulation);
  if (served.log) served.log(simulator);
  const auto figures = std::make_shared<Figures>(loop, judging...);
  simulator.AddLog(Hz(1000), Figures::Judged(loop), {figures});
  const auto limits = std::make_shared<LimitFigures>(loop.world.plant);
  simulator.AddLog(Hz(1000), LimitFigures::Signals(loop.world.plant), {InBackground(limits)});
  outputs.AddTo(simulator);

  const auto judge = [&](Summary& summary) {
    summary.Set("robot", ResourceName(scenario.robot));
    if constexpr (requires { loop.observer; })
      summary.Set("observer", IsReplaced(loop.observer) ? kMine : EnumName(*observer));
    figures->AddTo(summary);
    limits->AddTo(summary);
    if (served.figures) served.figures(summary, simulator);
    ros2.AddTo(summary, simulator);
    if constexpr (requires { loop.deployment; })
      if (loop.deployment) SetDeployment(simulator.context().Eval(loop.deployment->status), summary);
    summary.Set("evaluations", static_cast<double>(simulator.statistics().evaluations));
    outputs.AddTo(summary);
    double commanded = 0;
    if constexpr (requires { figures->commanded(); }) commanded = figures->commanded();
    if (!options.live && !wire.any()) {
      JudgeArrival(scenario, commanded, summary);
      scenario.task.AddTo(summary, scenario.walk ? EndOfWalk(*scenario.walk) : 0);
    }
  };
  std::vector<const Source*> signals = Figures::Signals(loop);
  signals.insert(signals.end(), faults.begin(), faults.end());
  std::vector<const OutputPort<Geometry>*> shapes = Figures::Shapes(loop);
  if (live) live->AddTo(signals, shapes);
  if (footholds != nullptr) shapes.push_back(footholds);
  outputs.AddTo(signals, shapes);
  return RunScenario(options, scenario, Describe(scenario, duration), duration, simulator, signals, shapes,
                     DriveLimits(loop.world.plant), judge, live ? live->Controls() : LiveControls(),
                     outputs.plots());
}

}  // namespace

void JudgeArrival(const QuadrupedScenario& scenario, double commanded, Summary& summary) {
  if (scenario.walk && scenario.task.arrives && commanded > 0)
    summary.Require("distance_m", {.low = std::max(1 - scenario.walk->path_tolerance, 0.0) * commanded},
                    EndOfWalk(*scenario.walk));
}

void SetDeployment(const DeploymentStatus& status, Summary& summary) {
  summary.Set("mode", EnumName(status.mode));
  summary.Set("fault", EnumName(status.fault));
  std::optional<double> damped;
  if (status.fault != DeploymentFault::kNone) damped = status.fault_time;
  summary.Set("damped_at_s", damped);
}

void CheckObserver(const std::optional<ObserverKind>& observer, const QuadrupedWalk& loop) {
  if (observer && IsReplaced(loop.observer))
    throw KeyError("observer",
                   fmt::format("'{}' has no effect, because this program replaces the block '{}': set the "
                               "key to null, set custom.blocks to shipped, or use --compare",
                               EnumName(*observer), loop.observer.path()));
}

void CheckQuadruped(const QuadrupedScenario& scenario, const Customisation<QuadrupedWalk>& customisation) {
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  if (scenario.walk) {
    const auto params = [&] { return MakeWalkParams(scenario); };
    CheckObserver(scenario.observer, AddDiagram(builder, params, customisation, scenario, outputs, faults));
  } else {
    const auto params = [&] { return MakeStandParams(scenario); };
    AddDiagram<QuadrupedStand>(builder, params, {}, scenario, outputs, faults);
  }
}

RunResult RunQuadruped(const QuadrupedScenario& scenario, const RunOptions& given,
                       const Customisation<QuadrupedWalk>& customisation, const Wire& wire) {
  RunOptions options = given;
  if (!wire.where.empty()) options.processor = 1;  // --drive uses the last one
  std::error_code ignored;                         // the recording of an earlier run
  if (!options.out.empty()) std::filesystem::remove(options.out / "wire.bin", ignored);
  if (!scenario.walk) {
    QuadrupedStandParams params = Blame("", [&] { return MakeStandParams(scenario); });
    if (wire.any()) params.world.min_height = kLying;
    return RunLoop<QuadrupedStand, StandFigures>(options, scenario, params, std::nullopt, {}, wire);
  }
  const QuadrupedWalkParams params = Blame("", [&] { return MakeWalkParams(scenario); });
  return RunLoop<QuadrupedWalk, WalkFigures>(
      options, scenario, params, params.observer.kind, customisation, wire, scenario.walk->judged_from_s,
      params.observer.kind != ObserverKind::kNone, MakePathVerdict(*scenario.walk, options.live != nullptr));
}

std::vector<ScenarioFile> LeggedFiles() {
  return {
      {"robot", "robots"}, {"walk.gaits", "gaits"}, {"profile", "profiles"}, {"hardware", "hardware/legged"}};
}

}  // namespace tenon::apps
