#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/real_time.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#ifdef TENON_WITH_UNITREE
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>
#endif

#include <fmt/core.h>

namespace tenon::apps {

std::string UnitreeLink(const char* option, const std::string& where) {
  constexpr std::string_view kRobot = "unitree:";
  if (where + ":" == kRobot) return "lo";
  if (where.starts_with(kRobot)) return where.substr(kRobot.size());
  throw ParameterError(
      fmt::format("{} {}: give unitree, unitree:INTERFACE or unitree:INTERFACE,DOMAIN, such as "
                  "unitree:eth0,0; in a scenario, robot: {{file: go2, link: {{unitree: eth0}}}}",
                  option, where));
}

std::string SetDriven(const std::string& name, const std::string& option, YamlDocument& document) {
  const auto scenario = document.Read<QuadrupedScenario>();
  const std::string link = option.empty() ? Blame("robot", [&] { return LoadPlace(scenario.robot); })
                                          : UnitreeLink("--drive", option);
  if (link.empty()) return link;
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("--drive: '{}' stands; choose a scenario that walks, such as flat", name));
  document.Set("robot.link.unitree", link);
  if (document.Value("robot.file") == "dogbot") document.Set("robot.file", "go2");
  document.Set("walk.state", "estimated");
  // The estimator would take what the sensors of a robot say as exact, and keep every error.
  if (ResourceName(scenario.hardware) == "ideal") document.Set("hardware", "standard");
  document.Set("sensors.foot_force.mounted", "none");
  if (!scenario.deployment) document.Set("deployment", "{initial: passive}");
  return link;
}

#ifdef TENON_WITH_UNITREE

static DdsLink LinkOf(const char* option, const Wire& wire) {
  if (!wire.replay.empty()) return {};
  const auto [interface, domain] = SplitLink(option, wire.where);
  return {.domain = domain.value_or(interface == "lo" ? 1 : 0), .interface = interface};
}

/// Sets the numbers of messages and of those refused, and the times of ticks.
template <class T>
static void SetReceived(const std::string& what, const DdsInput<T>& input, const Simulator& simulator,
                        Summary& summary) {
  const RefusedMessages& refused = simulator.context().Eval(input.refused);
  summary.Set(what + "s", static_cast<double>(simulator.context().Eval(input.taken).number));
  summary.Set(what + "s_refused", static_cast<double>(refused.count));
  if (refused.count > 0) summary.Note("the last refused " + what + ": " + refused.reason);
  SetRealTime(simulator.real_time(), summary);
}

Served Serve(const Wire& wire, DiagramBuilder& builder, QuadrupedStand& loop,
             const std::filesystem::path& out) {
  const DdsLink link = LinkOf("--serve", wire);
  UnitreeServerParams params{
      .link = link, .initial = HoldStance(loop.pd.params), .expired = DampedJoints(loop.pd.params.robot)};
  const auto recorder = std::make_shared<WireRecorder>(wire, out);
  if (wire.replay.empty()) {
    Say(fmt::format(
        "serving rt/lowcmd and rt/lowstate in domain {} at {}; the robot stands until a client commands\n",
        link.domain, link.interface));
  } else {
    params.replay = recorder->Received(params.initial);
  }
  auto& server = builder.Replace<UnitreeServer>(loop.pd, params);
  server.ConnectSensors(builder, loop.world);
  return {[recorder, &server, rate = params.command_rate](Simulator& simulator) {
            recorder->AddTo(simulator, rate, {&server.command.y, &server.checksum});
          },
          [recorder, &server, wire](Summary& summary, const Simulator& simulator) {
            recorder->AddTo(summary);
            if (wire.replay.empty()) SetReceived("command", server.command, simulator, summary);
          }};
}

constexpr double kReady = 6;  // from the start to the walk [s]

/// Damps the joints of a robot at the end of a run that has begun, and then releases them.
class LastCommands {
 public:
  LastCommands(const DdsLink& link, const Deployment& deployment, const Simulator& simulator)
      : sender_(internal::MakeDdsSender({"rt/lowcmd", link, false}, DdsMessageOf<UnitreeCommand>::Get())),
        deployment_(deployment),
        simulator_(simulator) {}
  ~LastCommands() { Send(); }
  LastCommands(const LastCommands&) = delete;
  LastCommands& operator=(const LastCommands&) = delete;

  void Damp() { Repeat({deployment_.Damped()}, 1); }
  void Send() {
    if (sent_ || simulator_.context().time() <= 0) return;
    sent_ = true;
    constexpr int kPassive = 5;  // against a loss
    if (simulator_.context().Eval(deployment_.status).mode != DeploymentMode::kPassive)
      Repeat({deployment_.Damped()}, static_cast<int>(deployment_.params.damp_time / kPeriod.count()));
    Repeat({}, kPassive);
  }

 private:
  static constexpr std::chrono::duration<double> kPeriod{0.002};
  void Repeat(const UnitreeCommand& command, int times) {
    for (int i = 0; i < times; ++i) {
      sender_->Send(0, &command, memory_);
      std::this_thread::sleep_for(kPeriod);
    }
  }
  std::unique_ptr<internal::DdsSender> sender_;
  const Deployment& deployment_;
  const Simulator& simulator_;
  std::vector<char> memory_;
  bool sent_ = false;
};

/// Collects the times from the sending of a state by the robot to the command that answers it.
class RoundTrip final : public LogSink {
 public:
  explicit RoundTrip(const DdsInput<UnitreeState>& input) : input_(input) {}
  void Row(std::span<const double> row) override {
    if (row[1] == state_) return;
    state_ = row[1];
    const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
    times_.Add(now.count() - input_.sent());
  }
  void AddTo(Summary& summary) const {
    if (times_.Below(1e-6) == 0 && times_.Below(1) == times_.count())
      return SetTimes("round_trip", times_, summary);
    summary.Note(
        "there is no round_trip_us, because the clock of the robot is another: set both by NTP or PTP");
  }

 private:
  const DdsInput<UnitreeState>& input_;
  double state_ = 0;  ///< time of the last state [s]
  TimeQuantiles times_;
};

static std::string DampedAt(const DeploymentStatus& status) {
  return fmt::format("the joints were damped at {:.4g} s (fault: {})", status.fault_time,
                     EnumName(status.fault));
}

RunResult Drive(const Wire& wire, QuadrupedScenario scenario, RunOptions options) {
  const bool repeats = !wire.replay.empty();
  const DdsLink link = LinkOf("--drive", wire);
  WalkScheduleParams& path = scenario.walk->path;
  const double end = kReady + EndOfWalk(*scenario.walk);
  double duration = scenario.duration_s.value_or(end + 2 + 2 * scenario.deployment->rise_time);
  scenario.report = {};  // its plots are of a simulated robot
  QuadrupedScenario given = scenario;
  given.duration_s = duration;
  path.segments.insert(path.segments.begin(), {.gait = Gait::kStand, .duration = kReady});
  if (scenario.deployment->goals.empty())
    scenario.deployment->goals = {{0, DeploymentGoal::kLie},
                                  {1, DeploymentGoal::kStand},
                                  {kReady - 1, DeploymentGoal::kWalk},
                                  {end + 1, DeploymentGoal::kLie}};
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  QuadrupedWalkParams params = Blame("", [&] { return MakeWalkParams(scenario); });
  WireRecorder recorder(wire, options.out);
  UnitreeWorldParams on_wire{.link = link, .initial = params.world.plant.initial};
  on_wire.replay = recorder.Received(UnitreeState());
  if (params.locomotion.mpc)
    params.locomotion.calculation = {
        .thread = true, .replay = recorder.Durations(on_wire.rate), .rate = on_wire.rate};
  auto& loop = AddDiagram<QuadrupedWalk>(
      builder, [&] { return params; }, {}, scenario, outputs, faults);
  Ros2Outputs ros2(builder, options);
  const std::chrono::duration<double> epoch = std::chrono::system_clock::now().time_since_epoch();
  AddRos2(builder, ros2, scenario, loop, nullptr, RobotTimes{on_wire.rate, epoch.count()});
  UnitreeWorld& robot = DriveUnitree(builder, loop, on_wire);
  std::vector<const Source*> signals{
      &robot.from_robot.y,   &loop.estimator->estimate, &loop.locomotion.body,    &loop.locomotion.schedule,
      &loop.observer.wrench, &loop.deployment->status,  &loop.deployment->command};
  std::vector<const Source*> recorded{&robot.from_robot.y, &robot.checksum};
  if (const OutputPort<double>* age = loop.locomotion.mpc_age) {
    signals.push_back(age);
    recorded.insert(recorded.begin() + 1, age);
  }
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.real_time_rate = repeats ? 0.0 : 1.0});
  recorder.AddTo(simulator, on_wire.rate, recorded);
  std::optional<LastCommands> last;
  const auto round_trip = std::make_shared<RoundTrip>(robot.from_robot);
  if (repeats) {
    duration = std::min(duration, recorder.recorded().end());
  } else {
    options.processor = 0;
    simulator.AddLog(on_wire.rate, {&robot.heartbeat}, {round_trip});
    if (!LeaveBuiltInMode(link, link.interface == "lo" ? 0.5 : 2))
      Say("warning: nobody answers requests to leave the built-in mode; a simulator may have none\n");
    last.emplace(link, *loop.deployment, simulator);
    simulator.AddMonitor([&](Context& context) -> Verdict {
      if (SignalGuard::caught() != 0) last->Damp();  // before the files are written
      const DeploymentStatus& status = context.Eval(loop.deployment->status);
      if (status.fault == DeploymentFault::kNone || status.mode != DeploymentMode::kPassive) return {};
      return DampedAt(status);
    });
    Say(fmt::format(
        "driving the robot of domain {} at {}; Ctrl-C, or L2 and B of the remote, damp its joints\n",
        link.domain, link.interface));
  }
  const auto judge = [&](Summary& summary) {
    if (last) {
      last->Send();
      SetReceived("state", robot.from_robot, simulator, summary);
      round_trip->AddTo(summary);
    }
    recorder.AddTo(summary);
    ros2.AddTo(summary, simulator);
    const Context& context = simulator.context();
    const DeploymentStatus& status = context.Eval(loop.deployment->status);
    SetDeployment(status, summary);
    if (status.fault != DeploymentFault::kNone)  // also where the controller of a damped robot ended the run
      summary.EndedBy(DampedAt(status), kLimitBroken);
    const Vec<2> begin = params.world.plant.initial.p_WB.head<2>();
    summary.Set("distance_m", (context.Eval(loop.estimator->estimate).state.p_WB.head<2>() - begin).norm());
    JudgeArrival(scenario, (context.Eval(loop.locomotion.com_planner.path).position_W - begin).norm(),
                 summary);
  };
  return RunScenario(options, given, Describe(given, duration), duration, simulator, signals,
                     {&loop.view.geometry}, {}, judge);
}

#else

[[noreturn]] static void ThrowWithoutDds(const char* option, const std::string& where) {
  throw ParameterError(
      fmt::format("{} {}: this build has no Cyclone DDS: install cyclonedds-dev and "
                  "cyclonedds-tools, and build Tenon again",
                  option, where));
}
Served Serve(const Wire& wire, DiagramBuilder&, QuadrupedStand&, const std::filesystem::path&) {
  ThrowWithoutDds("--serve", wire.where);
}
RunResult Drive(const Wire& wire, QuadrupedScenario, RunOptions) {
  ThrowWithoutDds("--drive", wire.where);
}

#endif

}  // namespace tenon::apps
