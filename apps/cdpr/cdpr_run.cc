#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_limits.h>
#include <tenon/apps/cdpr/cdpr_run.h>
#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/diagrams/cdpr/cdpr_messages.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

std::string Describe(const CdprScenario& scenario, const std::string& controllers) {
  return fmt::format("{} with {}, {} s, seed {}", ResourceName(scenario.robot), controllers,
                     scenario.duration_s, scenario.seed);
}

void CheckCdpr(const CdprScenario& scenario, const Customisation<CdprLoop>& customisation) {
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  AddDiagram(
      builder, [&] { return MakeLoopParams(scenario); }, customisation, scenario, outputs, faults);
}

/// Sends the messages of a cable robot, if anybody wants them.
static void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const CdprLoop& loop) {
  if (!outputs.any()) return;
  const int cables = RobotOf(loop.world.plant).num_cables();
  auto& messages = builder.Add<CdprMessages>("messages", {.num_cables = cables});
  builder.Connect(loop.platform, messages.platform);
  builder.Connect(loop.world.cables, messages.cables);
  builder.Connect(loop.world.inertial, messages.inertial);
  outputs.Send("joint_states", messages.joint_states);
  outputs.Send("imu", messages.imu);
  outputs.Send("odom", messages.odometry);
  outputs.Send("tf", messages.tf);
  if (loop.observer.load != nullptr) {
    builder.Connect(loop.observer.load->load, messages.load);
    outputs.Send("disturbance", messages.disturbance);
  }
  outputs.SendClock();
}

RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options,
                  const Customisation<CdprLoop>& customisation) {
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  auto& loop = AddDiagram(
      builder, [&] { return MakeLoopParams(scenario); }, customisation, scenario, outputs, faults);
  if (const std::string note = PayOutNote(*loop.reference.params.path); !note.empty())
    PrintNotes(options, {note});
  std::optional<CdprLive> live;
  if (options.live) live.emplace(builder, loop);
  Ros2Outputs ros2(builder, options);
  AddRos2(builder, ros2, loop);
  const auto diagram = builder.Build();
  SimulatorOptions simulation = MakeSimulatorOptions(scenario);
  if (options.ros2 && !options.live) simulation.real_time_rate = 1;
  Simulator simulator(*diagram, simulation);
  std::vector<const Source*> signals = CdprFigures::Signals(loop);
  const auto figures =
      std::make_shared<CdprFigures>(loop, scenario.payload.attach_s, scenario.payload.release_s,
                                    MakePathVerdict(scenario, options.live != nullptr));
  simulator.AddLog(scenario.pd.rate, signals, {figures});
  const auto limits = std::make_shared<CdprLimits>(loop, scenario.cable_diameter_m);
  simulator.AddLog(scenario.pd.rate, CdprLimits::Signals(loop), {limits});
  std::shared_ptr<MpcFigures> solves;
  if (const CdprMpc* mpc = loop.control.mpc) {
    solves = std::make_shared<MpcFigures>(*mpc);
    simulator.AddLog(scenario.mpc.params.rate, MpcFigures::Signals(*mpc), {solves});
  }
  outputs.AddTo(simulator);
  signals.insert(signals.end(), faults.begin(), faults.end());
  const CdprPlant& plant = loop.world.plant;
  if (HasElements(plant.added_speeds)) {
    signals.push_back(&plant.added_positions);
    signals.push_back(&plant.added_speeds);
  }
  if (CurrentBlock(plant) != &CurrentAs(plant) || CurrentAs(plant).params.extend)
    signals.push_back(&plant.added_wrench);
  std::vector<const OutputPort<Geometry>*> shapes{&loop.world.plant.geometry, &loop.reference.geometry};
  if (loop.control.mpc_age != nullptr) signals.push_back(loop.control.mpc_age);
  if (loop.world.gusts != nullptr) signals.push_back(&loop.world.gusts->wrench);
  if (loop.world.hanging_load != nullptr) {
    signals.push_back(&loop.world.hanging_load->load);
    shapes.push_back(&loop.world.hanging_load->geometry);
  }

  signals = Present(signals);
  shapes = Present(shapes);
  if (live) live->AddTo(signals);
  outputs.AddTo(signals, shapes);

  const CdprDescription& robot = RobotOf(loop.world.plant);
  Limits tension;
  if (KnowsLimits<CdprPlantParams>(plant))
    tension = {.low = robot.tension_min().minCoeff(), .high = robot.tension_max().maxCoeff()};
  const System& control =
      loop.control.mpc != nullptr ? static_cast<const System&>(*loop.control.mpc) : *loop.control.pd;
  const std::string controller(IsReplaced(control) ? kMine : EnumName(scenario.controller));
  const auto judge = [&](Summary& summary) {
    summary.Set("controller", controller);
    figures->AddTo(summary);
    // Commands stay within the bounds; the plant's tensions are judged by CdprMonitor, which may end the run.
    summary.Limit("command_min_N", {.low = tension.low});
    summary.Limit("command_max_N", {.high = tension.high});
    if (scenario.forbid_slack) summary.Limit("tension_min_N", {.low = 0});
    if (tension.high) summary.Limit("tension_max_N", {.high = scenario.max_tension_ratio * *tension.high});
    limits->AddTo(summary);
    ros2.AddTo(summary, simulator);
    figures->path().AddTo(summary);
    if (solves) solves->AddTo(summary);
    outputs.AddTo(summary);
    if (!options.live) scenario.task.AddTo(summary);
  };
  return RunScenario(options, scenario, Describe(scenario, controller), scenario.duration_s, simulator,
                     signals, shapes,
                     {{SignalName(loop.world.plant.cables, &CableSignals::tension), tension},
                      {SignalName(loop.command), tension}},
                     judge, live ? live->Controls() : LiveControls(), outputs.plots());
}

}  // namespace tenon::apps
