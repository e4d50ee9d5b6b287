#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/progress.h>
#include <tenon/apps/quadruped/quadruped_ros2.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/serving.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/text/parse_number.h>
#ifdef TENON_WITH_UNITREE
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>
#endif

#include <fmt/core.h>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

namespace tenon::apps {

void SetDriven(const std::string& name, YamlDocument& document) {
  const auto scenario = document.Read<QuadrupedScenario>();
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("--drive: '{}' stands; choose a scenario that walks, such as flat", name));
  if (document.Value("robot") == "dogbot") document.Set("robot", "go2");
  document.Set("walk.state", "estimated");
  document.Set("sensors.foot_force.mounted", "none");
  if (!scenario.deployment) document.Set("deployment", "{initial: passive}");
}

#ifdef TENON_WITH_UNITREE

static DdsLink LinkOf(const char* option, const std::string& where) {
  const std::size_t colon = where.find(':'), comma = where.find(',', colon);
  const std::string robot = where.substr(0, colon);
  const std::string interface = colon == where.npos ? "lo" : where.substr(colon + 1, comma - colon - 1);
  const auto domain = comma == where.npos ? std::optional(interface == "lo" ? 1 : 0)
                                          : internal::NumberIn<int>(where.substr(comma + 1));
  if (robot != "unitree" || interface.empty() || !domain)
    throw ParameterError(fmt::format(
        "{} {}: give unitree, unitree:INTERFACE or unitree:INTERFACE,DOMAIN, such as unitree:eth0,0", option,
        where));
  return {.domain = *domain, .interface = interface};
}

/// Sets the numbers of messages, of those refused, and of late ticks.
template <class T>
static void SetReceived(const std::string& what, const DdsInput<T>& input, const Simulator& simulator,
                        Summary& summary) {
  const RefusedMessages& refused = simulator.context().Eval(input.refused);
  summary.Set(what + "s", static_cast<double>(simulator.context().Eval(input.taken).number));
  summary.Set(what + "s_refused", static_cast<double>(refused.count));
  if (refused.count > 0) summary.Note("the last refused " + what + ": " + refused.reason);
  summary.Set("ticks_missed", static_cast<double>(simulator.real_time().missed));
  summary.Set("tick_late_max_s", simulator.real_time().worst_lateness);
}

std::function<void(Summary&, const Simulator&)> Serve(const std::string& where, DiagramBuilder& builder,
                                                      QuadrupedStand& loop) {
  const DdsLink link = LinkOf("--serve", where);
  const UnitreeServerParams params{.link = link, .initial = HoldStance(loop.pd.params)};
  auto& server = builder.Replace<UnitreeServer>(loop.pd, params);
  server.ConnectSensors(builder, loop.world);
  Say(fmt::format(
      "serving rt/lowcmd and rt/lowstate in domain {} at {}; the robot stands until a client commands\n",
      link.domain, link.interface));
  return [&command = server.command](Summary& summary, const Simulator& simulator) {
    SetReceived("command", command, simulator, summary);
  };
}

constexpr double kReady = 6;  // from the start to the walk [s]

/// Damps the joints of a robot at the end of a run that has begun.
class LastCommand {
 public:
  LastCommand(const DdsLink& link, const Deployment& deployment, const Simulator& simulator)
      : sender_(internal::MakeDdsSender({"rt/lowcmd", link, false}, DdsMessageOf<UnitreeCommand>::Get())),
        command_{deployment.Damped()},
        simulator_(simulator) {}
  ~LastCommand() { Send(); }
  LastCommand(const LastCommand&) = delete;
  LastCommand& operator=(const LastCommand&) = delete;

  void Send() {
    constexpr int kTimes = 5;  // against a loss
    for (int i = 0; i < kTimes && !sent_ && simulator_.context().time() > 0; ++i) {
      sender_->Send(0, &command_, memory_);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    sent_ = true;
  }

 private:
  std::unique_ptr<internal::DdsSender> sender_;
  UnitreeCommand command_;
  const Simulator& simulator_;
  std::vector<char> memory_;
  bool sent_ = false;
};

RunResult Drive(const std::string& where, QuadrupedScenario scenario, const RunOptions& options) {
  const DdsLink link = LinkOf("--drive", where);
  WalkScheduleParams& path = scenario.walk->path;
  const double end = kReady + EndOfWalk(*scenario.walk);
  path.segments.insert(path.segments.begin(), {.gait = Gait::kStand, .duration = kReady});
  if (scenario.deployment->goals.empty())
    scenario.deployment->goals = {{0, DeploymentGoal::kLie},
                                  {1, DeploymentGoal::kStand},
                                  {kReady - 1, DeploymentGoal::kWalk},
                                  {end + 1, DeploymentGoal::kLie}};
  const double duration = scenario.duration_s.value_or(end + 2 + 2 * scenario.deployment->rise_time);
  scenario.report = {};  // its plots are of a simulated robot
  DiagramBuilder builder;
  Outputs outputs(builder);
  std::vector<const Source*> faults;
  const QuadrupedWalkParams params = Blame("", [&] { return MakeWalkParams(scenario); });
  auto& loop = AddDiagram<QuadrupedWalk>(
      builder, [&] { return params; }, {}, scenario, outputs, faults);
  Ros2Outputs ros2(builder, options);
  const std::chrono::duration<double> epoch = std::chrono::system_clock::now().time_since_epoch();
  AddRos2(builder, ros2, scenario, loop, nullptr, epoch.count());
  UnitreeWorld& robot = DriveUnitree(builder, loop, {.link = link, .initial = params.world.plant.initial});
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.real_time_rate = 1});
  LastCommand last(link, *loop.deployment, simulator);
  Say(fmt::format(
      "driving the robot of domain {} at {}; Ctrl-C, or L2 and B of the remote, damp its joints\n",
      link.domain, link.interface));
  const auto judge = [&](Summary& summary) {
    last.Send();
    SetReceived("state", robot.from_robot, simulator, summary);
    ros2.AddTo(summary, simulator);
    SetDeployment(simulator.context().Eval(loop.deployment->status), summary);
  };
  return RunScenario(options, scenario, Describe(scenario, duration), duration, simulator,
                     {&robot.from_robot.y, &loop.estimator->estimate, &loop.locomotion.body,
                      &loop.locomotion.schedule, &loop.deployment->status, &loop.deployment->command},
                     {&loop.view.geometry}, {}, judge);
}

#else

[[noreturn]] static void ThrowWithoutDds(const char* option, const std::string& where) {
  throw ParameterError(
      fmt::format("{} {}: this build has no Cyclone DDS: install cyclonedds-dev and "
                  "cyclonedds-tools, and build Tenon again",
                  option, where));
}
std::function<void(Summary&, const Simulator&)> Serve(const std::string& where, DiagramBuilder&,
                                                      QuadrupedStand&) {
  ThrowWithoutDds("--serve", where);
}
RunResult Drive(const std::string& where, QuadrupedScenario, const RunOptions&) {
  ThrowWithoutDds("--drive", where);
}

#endif

}  // namespace tenon::apps
