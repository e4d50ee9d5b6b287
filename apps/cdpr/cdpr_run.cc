#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_run.h>
#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/diagrams/cdpr/cdpr_messages.h>
#include <tenon/systems/yaml/resources.h>

#include <Eigen/Geometry>
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

namespace {

constexpr double kNever = 1e9;  // [s], since recordings cannot store infinity

/// A spring with a quarter of the platform's weight at 0.25 m, saturated at half of the weight, with a fifth
/// of the critical damping.
PlatformPullParams PullFor(const CdprDescription& robot) {
  const double weight = kGravity * robot.mass, stiffness = weight;
  return {stiffness, 0.2 * 2 * std::sqrt(stiffness * robot.mass), weight / 2};
}

const std::shared_ptr<const EquilibriumPath>& PathOf(const CdprLoop& loop) {
  return CurrentAs<LeafSystem<ReferenceGeneratorParams>>(loop.reference).params.path;
}

}  // namespace

CdprLive::CdprLive(DiagramBuilder& builder, CdprLoop& loop)
    : loop_(loop),
      pull_(builder.Add<PlatformPull>("live_pull", PullFor(RobotOf(loop.world.plant)))),
      goal_(builder.Add<GoalPath>("live_goal", GoalPathParams{.path = PathOf(loop)})) {
  // A block of the user's may lack an input; the live page then lacks what it is for.
  const auto connect = [&](auto& input) {
    if (FindCurrent(input) != nullptr) builder.Connect(goal_.path, input);
  };
  connect(loop.reference.path);
  if (loop.control.mpc != nullptr) connect(loop.control.mpc->path);
  builder.Connect(loop.world.plant.platform, pull_.platform);
  acts_ = FindCurrent(loop.world.plant.wrench) != nullptr && KnowsLimits<CdprPlantParams>(loop.world.plant);
  if (acts_) builder.InsertBefore(loop.world.plant.wrench, pull_.others, pull_.wrench);
}

LiveControls CdprLive::Controls() const {
  LiveControls controls;
  if (FindCurrent(loop_.reference.path) != nullptr) controls.goal = Goal();
  LiveControls::Pull pull;
  pull.stiffness = pull_.params.stiffness;
  pull.max_force = pull_.params.max_force;
  pull.bodies[0] = "platform";
  pull.set = [this](Context& context, std::size_t, const Vec<3>& point_W, const Vec<3>& target_W,
                    bool first) {
    PlatformGrip grip = context.Eval(pull_.grip);
    grip.on = true;
    grip.target_W = target_W;
    if (first) {
      const PlatformState& platform = context.Eval(loop_.world.plant.platform);
      grip.p_B = platform.R_WB().transpose() * (point_W - platform.p_WB);
    }
    return LiveSets{SetTo(pull_.grip, grip)};
  };
  pull.release = [this] { return LiveSets{SetTo(pull_.grip, {})}; };
  pull.state = [this](Context& context) {
    const PlatformState& platform = context.Eval(loop_.world.plant.platform);
    const PlatformGrip& grip = context.Eval(pull_.grip);
    const Vec<3> point = platform.p_WB + platform.R_WB() * grip.p_B;
    return std::pair(point, pull_.Force(platform, grip));
  };
  if (!acts_) return controls;
  controls.pull = std::move(pull);
  const PayloadSchedule& payload = CurrentAs(loop_.world.payload);
  if (CurrentBlock(payload) != &payload) return controls;
  const double mass = RobotOf(loop_.world.plant).mass;
  controls.load = {
      "payload", {0.01 * mass, 0.5 * mass}, 0.2 * mass, [&payload](Context& context, double load) {
        if (load == 0) return LiveSets{SetTo(payload.release, context.time())};
        return LiveSets{SetTo(payload.load, {load, context.Eval(payload.load).p_B}),
                        SetTo(payload.release, kNever), SetTo(payload.attach, context.time())};
      }};
  return controls;
}

/// The box between the anchors, before and after they move, and the floor. GoalPath refuses goals that the
/// robot cannot reach.
LiveControls::Goal CdprLive::Goal() const {
  Eigen::AlignedBox3d box;
  const CdprDescription& robot = RobotOf(loop_.world.plant);
  const MovingAnchors anchors(robot);
  for (const double time : {0.0, anchors.end_time()})
    for (const CableDescription& cable : anchors.RobotAt(robot, time).cables) box.extend(cable.anchor_W);
  const Vec<3> start = PathOf(loop_)->At(0).position;
  box.extend(start);
  if (!robot.on_table) box.extend(Vec<3>(start[0], start[1], robot.floor));
  return {"reference", {box.min(), box.max()}, [this](Context& context, const Vec<3>& place) {
            const CdprReference& reference = context.Eval(loop_.reference.reference);
            return LiveSets{SetTo(goal_.goal, goal_.GoalAt(place, context.time(), reference))};
          }};
}

}  // namespace tenon::apps
