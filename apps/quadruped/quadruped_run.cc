#include <tenon/apps/common/faults.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_messages.h>
#include <tenon/plants/robots/load_robot.h>
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
  const SizeRatio ratio = RatioOf(scenario);
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
      scenario.task.AddTo(summary, scenario.walk ? EndOfWalk(*scenario.walk) : 0, ratio.weight, ratio.length);
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

namespace {

constexpr double kDropHeight = 0.1;  // height above the trunk from which the load drops [m]
constexpr double kLoadEdge = 0.12;   // edge of the load as SlidingLoad draws it [m]
constexpr std::array kGaits{Gait::kTrot, Gait::kCrawl, Gait::kPace, Gait::kGallop};

Geometry ShapesOf(const QuadrupedPlant& plant) {
  const QuadrupedPlantParams& params = ParamsOf(plant);
  return MakeQuadrupedGeometry(params.robot, params.payload, params.terrain);
}

SlidingLoadParams LoadOn(const QuadrupedPlant& plant) {
  SlidingLoadParams params;
  const QuadrupedPlantParams& on = ParamsOf(plant);
  const RigidInertia& trunk = on.robot.trunk;
  const double half_height = ShapesOf(plant).front().size[2] / 2;
  params.position_B = trunk.com + Vec<3>(0, 0, half_height + kLoadEdge / 2);
  params.robot = on.initial;
  params.gravity = on.gravity;
  return params;
}

/// Adds a pull and a load to the forces on the robot, behind the first `params` ones.
class LiveForces final : public LeafSystem<std::size_t> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<ExternalForces> others{this, {"others"}, ExternalForces{}};
  InputPort<ExternalForce> pull{this, {"pull"}}, load{this, {"load"}};
  OutputPort<ExternalForces> forces{this, {"forces"}, Uses(others, pull, load), &LiveForces::CalcForces};

 private:
  ExternalForces CalcForces(const ExternalForces& others, const ExternalForce& pull,
                            const ExternalForce& load) const {
    ExternalForces all = others;
    all[params] = pull;
    all[params + 1] = load;
    return all;
  }
};

/// The body of each shape of the robot, by the index of the shape. Other shapes are omitted.
std::map<std::size_t, int> BodiesOf(const QuadrupedPlant& plant) {
  std::map<std::string, int> by_name{{"trunk", 0}};
  for (int j = 0; j < kNumJoints; ++j) by_name["link of " + ParamsOf(plant).robot.joint(j).name] = 1 + j;
  for (int leg = 0; leg < kNumLegs; ++leg)
    by_name[std::string("foot ") + kLegNames[static_cast<std::size_t>(leg)]] = kJointsPerLeg * (leg + 1);
  std::map<std::size_t, int> bodies;
  const Geometry shapes = ShapesOf(plant);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    if (by_name.contains(shapes[i].name)) bodies[i] = by_name[shapes[i].name];
  return bodies;
}

}  // namespace

/// Adds the block through which the command of a walk is overridden.
static WalkDrive& AddDrive(DiagramBuilder& builder, const std::string& name, WalkSchedule& walk) {
  const WalkScheduleParams& planned = CurrentAs<LeafSystem<WalkScheduleParams>>(walk).params;
  auto& drive = builder.Add<WalkDrive>(name, {.acceleration = planned.acceleration,
                                              .yaw_acceleration = planned.yaw_acceleration,
                                              .rate = planned.rate});
  builder.Insert(walk.command, drive.planned, drive.command);
  return drive;
}

QuadrupedLive::QuadrupedLive(DiagramBuilder& builder, QuadrupedWorld& world, WalkSchedule* walk,
                             const LiveScenario& limits)
    : limits_(limits),
      world_(world),
      pull_(builder.Add<SpringPull>("live_pull", SpringPullParams{.robot = ParamsOf(world.plant).robot})),
      load_(builder.Add<SlidingLoad>("live_load", LoadOn(world.plant))) {
  if (walk != nullptr) drive_ = &AddDrive(builder, "live_drive", *walk);
  builder.Connect(world.plant.state, pull_.state);
  builder.Connect(world.plant.state, load_.robot);
  acts_ = FindCurrent(world.plant.external) != nullptr && KnowsLimits<QuadrupedPlantParams>(world.plant);
  if (!acts_) return;
  const std::size_t used = CurrentAs<LeafSystem<ForceBundleParams>>(world.disturbances).params.count;
  Demand(used + 2 <= kMaxExternalForces,
         fmt::format("the scenario has {} forces, but a live run allows at most {}: remove some", used - 1,
                     kMaxExternalForces - 3));
  auto& forces = builder.Add<LiveForces>("live_forces", used);
  builder.Connect(pull_.force, forces.pull);
  builder.Connect(load_.force, forces.load);
  builder.InsertBefore(world.plant.external, forces.others, forces.forces);
}

void QuadrupedLive::AddTo(std::vector<const Source*>& signals,
                          std::vector<const OutputPort<Geometry>*>& shapes) const {
  if (drive_ != nullptr) signals.push_back(&drive_->command);
  signals.push_back(&pull_.force);
  signals.push_back(&load_.force);
  shapes.push_back(&load_.geometry);
}

LiveControls QuadrupedLive::Controls() const {
  LiveControls controls;
  if (drive_ != nullptr) {
    const WalkDrive& drive = *drive_;
    const LiveSet active = SetTo(drive.active, true);
    const auto range = [](const Vec<2>& limits) { return std::array{limits[0], limits[1]}; };
    controls.drive = {range(limits_.forward_m_per_s), range(limits_.sideways_m_per_s),
                      range(limits_.yaw_rad_per_s), [&drive, active](const Vec<3>& velocity) {
                        return LiveSets{active, SetTo(drive.velocity, velocity)};
                      }};
    controls.gaits = {{}, [&drive, active](std::size_t i) {
                        return LiveSets{active, SetTo(drive.gait, kGaits[i])};
                      }};
    for (const Gait gait : kGaits) controls.gaits->names.emplace_back(EnumName(gait));
    controls.postures = {
        {"walk", "stand", "squat"}, [&drive, active, squat = limits_.squat_m](std::size_t i) {
          return LiveSets{active, SetTo(drive.stands, i != 0), SetTo(drive.height, i == 2 ? -squat : 0.0)};
        }};
  }

  if (!acts_) return controls;
  const QuadrupedPlant& plant = world_.plant;
  const QuadrupedDescription& robot = ParamsOf(plant).robot;
  const std::map<std::size_t, int> bodies = BodiesOf(plant);
  LiveControls::Pull pull;
  pull.stiffness = pull_.params.stiffness;
  pull.max_force = pull_.params.max_force;
  const Geometry shapes = ShapesOf(plant);
  for (const auto& [shape, body] : bodies) pull.bodies[shape] = shapes[shape].name;
  pull.set = [this, &robot, bodies](Context& context, std::size_t shape, const Vec<3>& point_W,
                                    const Vec<3>& target_W, bool first) {
    SpringGrip grip = context.Eval(pull_.grip);
    grip.on = true;
    grip.target_W = target_W;
    if (first) {
      grip.body = bodies.at(shape);
      grip.p_B = PointInBody(robot, context.Eval(world_.plant.state), grip.body, point_W);
    }
    return LiveSets{SetTo(pull_.grip, grip)};
  };
  pull.release = [this] { return LiveSets{SetTo(pull_.grip, {})}; };
  pull.state = [this, &robot](Context& context) {
    const SpringGrip& grip = context.Eval(pull_.grip);
    const LeggedState& x = context.Eval(world_.plant.state);
    return std::pair(PointOfBody(robot, x, grip.body, grip.p_B).p_W, context.Eval(pull_.force).force_W);
  };
  controls.pull = std::move(pull);

  const double largest = std::round(limits_.load_ratio * robot.mass());
  controls.load = {
      "trunk load", {0.1, largest}, std::min(5.0, largest / 2), [this](Context& context, double mass) {
        const LeggedState& x = context.Eval(world_.plant.state);
        const Eigen::Vector3d arm =
            x.R_WB() * (load_.params.position_B + Vec<3>(0, 0, mass > 0 ? kDropHeight : 0));
        const Vec<3> place = x.p_WB + arm, velocity = x.v_W + x.w_W.cross(arm);
        return LiveSets{SetTo(load_.mass, mass), SetTo(load_.motion, {place, velocity})};
      }};
  return controls;
}

namespace {

QuadrupedMessages& AddMessages(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
                               const QuadrupedWorld& world, const OutputPort<LeggedState>& state,
                               const std::optional<RobotTimes>& wire) {
  const QuadrupedMessagesParams params = Blame("robot", [&] {
    return QuadrupedMessagesParams{LoadQuadruped(scenario.robot), LoadRobotLinks(scenario.robot),
                                   wire ? wire->epoch : 0};
  });
  auto& messages = builder.Add<QuadrupedMessages>("messages", params);
  builder.Connect(state, messages.state);
  builder.Connect(world.joints, messages.joints);
  builder.Connect(world.measured_torque, messages.torque);
  builder.Connect(world.inertial, messages.inertial);
  outputs.Send("joint_states", messages.joint_states, wire ? wire->rate : world.encoders.params.rate);
  outputs.Send("imu", messages.imu, wire ? wire->rate : world.imu.params.rate);
  outputs.Send("odom", messages.odometry);
  outputs.Send("tf", messages.tf);
  outputs.SendOnce("tf_static", messages.tf_static);
  outputs.SendDescription(params.links.urdf);
  if (!wire) outputs.SendClock();
  return messages;
}

void SendFootForces(DiagramBuilder& builder, Ros2Outputs& outputs, const OutputPort<FootForces>& forces,
                    QuadrupedMessages& messages, Rate rate) {
  builder.Connect(forces, messages.foot_forces);
  for (const auto* foot :
       {&messages.front_left, &messages.front_right, &messages.rear_left, &messages.rear_right})
    outputs.Send("foot_force/" + foot->name(), *foot, rate);
}

void SendCommands(DiagramBuilder& builder, Ros2Outputs& outputs, const OutputPort<Vec<12>>& torque,
                  QuadrupedMessages& messages, Rate rate) {
  builder.Connect(torque, messages.command);
  outputs.Send("joint_commands", messages.joint_commands, rate);
}

}  // namespace

void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedWalk& walk, WalkDrive* drive, const std::optional<RobotTimes>& wire) {
  if (!outputs.any()) return;
  QuadrupedMessages& messages = AddMessages(builder, outputs, scenario, walk.world, walk.state, wire);
  SendFootForces(builder, outputs,
                 walk.foot_forces_of_legs != nullptr   ? walk.foot_forces_of_legs->forces
                 : walk.foot_force_estimate != nullptr ? walk.foot_force_estimate->forces
                                                       : walk.world.foot_forces,
                 messages, wire ? wire->rate : walk.world.foot_sensor.params.rate);
  if (walk.estimator != nullptr && !wire)
    outputs.Send("ground_truth",
                 builder.AddFunction("ground_truth", Uses(builder.time, walk.world.state),
                                     [base = messages.params.links.base](double t, const LeggedState& x) {
                                       auto truth = ros2::MakeOdometry(QuadrupedMessages::kOdom, base);
                                       truth.header.stamp = ros2::StampOf(t);
                                       ros2::SetOdometry(x.p_WB, x.q_WB, x.v_W, x.w_W, &truth);
                                       return truth;
                                     }));
  builder.Connect(walk.observer.wrench, messages.wrench);
  SendCommands(builder, outputs, walk.deployment != nullptr ? walk.drives->torque : walk.locomotion.torque,
               messages, wire ? wire->rate : walk.locomotion.whole_body.params.rate);
  outputs.Send("disturbance", messages.disturbance);
  const LiveScenario& live = scenario.live;
  const auto ends = [&](int i) {
    return Vec<3>(live.forward_m_per_s[i], live.sideways_m_per_s[i], live.yaw_rad_per_s[i]);
  };
  const OutputPort<VelocityCommand>* velocity = outputs.VelocityIn(ends(0), ends(1));
  if (velocity == nullptr) return;
  if (drive == nullptr) drive = &AddDrive(builder, "ros2_drive", walk.walk);
  builder.Connect(*velocity, drive->request);
}

void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedStand& stand, WalkDrive*) {
  if (!outputs.any()) return;
  QuadrupedMessages& messages = AddMessages(builder, outputs, scenario, stand.world, stand.world.state, {});
  SendFootForces(builder, outputs, stand.world.foot_forces, messages, stand.world.foot_sensor.params.rate);
  SendCommands(builder, outputs, stand.pd.torque, messages, stand.pd.params.rate);
}

}  // namespace tenon::apps
