#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/real_time.h>
#include <tenon/apps/quadruped/log_estimator.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/files/input_file.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

using WalkCustomisation = Customisation<QuadrupedWalk>;

/// The options of the command line that change a walk.
struct WalkArguments {
  std::string gait;             ///< gait of all segments that walk; empty: those of the scenario
  std::optional<double> speed;  ///< forward speed of all segments that move forward or backward [m/s]
  std::string observer;         ///< name of an ObserverKind; empty: the scenario's
  bool compare = false;         ///< one run for each observer
  std::string serve;            ///< see Serve; empty: the robot is not served
  std::string drive;            ///< see Drive; empty: the robot is simulated
  std::string estimate;         ///< see RunEstimate; empty: no log
  bool check_realtime = false;  ///< examines the machine
  std::string identify;         ///< see Identification: a log, or the directory of run.mcap

  bool any() const { return !gait.empty() || speed || !observer.empty() || compare; }
};

void AddWalkArguments(CommandLine& line, WalkArguments& walk) {
  line.Add("--gait", &walk.gait, "crawl, trot, pace or gallop (default: the scenario's)");
  line.Add("--speed", &walk.speed, "forward speed [m/s] (default: the scenario's)");
  line.Add("--observer", &walk.observer,
           "none, legs, com, hybrid, focchi, ndo_m, ndo_inverse or ndo_hybrid (default: the scenario's)");
  line.Add("--compare", &walk.compare,
           "make one run for each observer, each in its own directory below --out, and one report of all",
           {.excludes = "--observer"});
  line.Add("--serve", &walk.serve,
           "serve a standing robot in real time to a client on DDS, as a Go2 or B2 does: unitree, which is "
           "on this machine, or unitree:INTERFACE[,DOMAIN]",
           {.excludes = "--live"});
  line.Add("--drive", &walk.drive,
           "walk with a robot on DDS, a Go2 or B2, in real time, in place of the simulated one: unitree or "
           "unitree:INTERFACE[,DOMAIN]",
           {.excludes = "--live"});
  line.Add(
      "--estimate", &walk.estimate,
      "run estimator and observers of the scenario on a log of a robot, an MCAP file (default of SCENARIO: "
      "scenario.yaml beside it)");
  line.Add("--check-realtime", &walk.check_realtime,
           "measure for 6 s how late this machine begins ticks, and say what to change before --drive");
  line.Add("--identify", &walk.identify,
           "estimate as --estimate does, and find friction, rotor inertia, delay and load of the robot, from "
           "a log "
           "or the directory of a run with --mcap",
           {.excludes = "--estimate"});
}

/// Checks a scenario whose robot is served, and replaces DogBot, which no maker's client knows, by a Go2.
void SetServed(const std::string& name, YamlDocument& document) {
  if (document.Read<QuadrupedScenario>().walk)
    throw ParameterError(
        fmt::format("--serve: '{}' walks; choose a scenario that stands, such as stand", name));
  if (document.Value("robot") == "dogbot") document.Set("robot", "go2");
}

Variant MakeVariant(std::string name, const QuadrupedScenario& scenario,
                    const WalkCustomisation& customisation = {}) {
  return {std::move(name), [scenario, customisation](const RunOptions& each) {
            return RunQuadruped(scenario, each, customisation);
          }};
}

Report ReportOf(const QuadrupedScenario& scenario) {
  return ScenarioReport(scenario, Describe(scenario, Duration(scenario)));
}

int CompareObservers(const RunOptions& options, const QuadrupedScenario& scenario,
                     const WalkCustomisation& customisation) {
  std::vector<ObserverKind> kinds = scenario.compare;
  if (kinds.empty())
    for (const auto& [kind, name] : EnumNames(ObserverKind{})) kinds.push_back(kind);
  std::vector<Variant> variants;
  if (customisation) variants.push_back(MakeVariant(kMine, scenario, customisation));
  QuadrupedScenario shipped = scenario;
  shipped.custom.reset();
  for (const ObserverKind kind : kinds) {
    shipped.observer = kind;
    variants.push_back(MakeVariant(EnumName(kind), shipped));
  }
  return Compare(options, ReportOf(scenario), variants);
}

/// Sets gait, speed and observer of the command line in the scenario.
void SetWalk(const WalkArguments& walk, const std::string& name, YamlDocument& document) {
  const auto scenario = document.Read<QuadrupedScenario>();
  if (!scenario.walk)
    throw ParameterError(
        fmt::format("'{}' does not walk: remove --gait, --speed, --observer and --compare, or choose a "
                    "scenario that walks",
                    name));
  if (!walk.observer.empty()) document.Set("observer", walk.observer);
  for (std::size_t i = 0; i < scenario.walk->path.segments.size(); ++i) {
    const WalkSegment& segment = scenario.walk->path.segments[i];
    const std::string key = fmt::format("walk.path.segments.{}", i);
    if (segment.gait == Gait::kStand) continue;
    if (!walk.gait.empty()) document.Set(key + ".gait", walk.gait);
    if (walk.speed && segment.forward != 0)
      document.Set(key + ".forward_m_per_s", fmt::format("{}", *walk.speed));
  }
}

/// Reads a scenario with the keys of the customisation. Throws ParameterError and KeyError.
QuadrupedScenario ReadScenario(const YamlDocument& document, const WalkCustomisation& customisation) {
  auto scenario = customisation.ReadScenario<QuadrupedScenario>(document);
  if (customisation && !scenario.walk)
    throw KeyError("pd", "this program changes the diagram of a walk: choose a scenario that walks");
  return scenario;
}

/// Runs a scenario with the options of the command line: once, or once for each observer.
int RunCommand(YamlDocument document, const CommonArguments& arguments, const WalkArguments& walk,
               const RunOptions& options, const WalkCustomisation& customisation) {
  if (walk.any()) SetWalk(walk, arguments.scenario, document);
  if (!walk.serve.empty()) SetServed(arguments.scenario, document);
  const std::string drive = RunBlaming(document, [&] {
    return walk.serve.empty() ? SetDriven(arguments.scenario, walk.drive, document) : std::string();
  });
  if (!drive.empty() && (options.live || walk.compare))
    throw ParameterError("a robot is driven by one run without a page: remove --live and --compare");
  return RunBlaming(document, [&] {
    QuadrupedScenario scenario = ReadScenario(document, customisation);
    if (arguments.duration) scenario.duration_s = *arguments.duration;
    if (!options.live && scenario.walk)
      CheckJudged(scenario.walk->judged_from_s, Duration(scenario), arguments.duration.has_value());
    for (const std::string& warning : Blame("robot", [&] { return QuadrupedWarnings(scenario.robot); }))
      Say(fmt::format("warning: {}\n", warning));
    if (!drive.empty()) return PrintResult(Drive({drive}, scenario, options).summary, options);
    if (walk.compare) return CompareObservers(options, scenario, customisation);
    const Wire wire{walk.serve.empty() ? "" : UnitreeLink("--serve", walk.serve)};
    return PrintResult(RunQuadruped(scenario, options, customisation, wire).summary, options);
  });
}

/// Repeats the run that left this directory, and, if options or settings change its scenario, shows beside it
/// the run with the changes on the same input. Returns the exit code.
int ReplayRun(CommonArguments arguments, const WalkArguments& walk, const std::string& app,
              const WalkCustomisation& customisation) {
  namespace fs = std::filesystem;
  const fs::path run = std::exchange(arguments.replay, "");
  if (!arguments.scenario.empty() || arguments.seed || arguments.duration || !walk.serve.empty() ||
      !walk.drive.empty())
    throw ParameterError(
        "--replay DIRECTORY has scenario, seed, duration and robot of the run: remove these");
  arguments.scenario = (run / "scenario.yaml").string();
  if (arguments.out.empty()) arguments.out = (run / "replay").string();
  const RunOptions options = OptionsOf(arguments);
  std::error_code ignored;
  if (fs::equivalent(run, options.out, ignored))
    throw ParameterError(fmt::format("--out {} holds the run: name another directory", arguments.out));
  const bool wired = fs::exists(run / "wire.bin"), changed = walk.any() || !arguments.settings.empty();
  const auto variant = [&](std::string name, CommonArguments with, const WalkArguments& on) -> Variant {
    YamlDocument document = LoadScenario(with, app);
    if (on.any()) SetWalk(on, with.scenario, document);
    return {std::move(name), [=](const RunOptions& each) {
              const QuadrupedScenario scenario = ReadScenario(document, customisation);
              const Wire wire{.replay = run, .changed = on.any() || !with.settings.empty()};
              if (wired && scenario.walk) return Drive(wire, scenario, each);
              return RunQuadruped(scenario, each, customisation, wired ? wire : Wire{});
            }};
  };
  CommonArguments plain = arguments;
  plain.settings.clear();
  const Variant recorded = variant("recorded", plain, {});
  if (changed) {
    const auto scenario = ReadScenario(LoadScenario(plain, app), customisation);
    return Compare(options, ReportOf(scenario), {recorded, variant("changed", arguments, walk)});
  }
  const int code = PrintResult(recorded.run(options).summary, options);
  if (wired || code >= kOutputFailed) return code;
  const bool equal = ReadText(run / "signals.csv") == ReadText(options.out / "signals.csv");
  fmt::print("{:<28} {}\n", "signals.csv", equal ? "equal" : "DIFFERENT");
  return equal ? code : std::max<int>(code, kLimitBroken);
}

/// Runs a log through the scenario's estimator and observers. Returns the exit code.
int RunLog(CommonArguments arguments, const WalkArguments& walk, const std::string& app) {
  const bool identify = !walk.identify.empty();
  std::filesystem::path file = identify ? walk.identify : walk.estimate;
  if (std::filesystem::is_directory(file)) file /= "run.mcap";
  if (!walk.gait.empty() || walk.speed || walk.compare || !walk.serve.empty() || !walk.drive.empty() ||
      !arguments.live.empty() || !arguments.replay.empty() || !arguments.ros2.empty() || arguments.mcap)
    throw ParameterError(
        "--estimate and --identify take a SCENARIO, --set, --observer, --duration and --out: remove other "
        "options");
  if (const auto beside = file.parent_path() / "scenario.yaml";
      arguments.scenario.empty() && std::filesystem::exists(beside))
    arguments.scenario = beside.string();
  if (arguments.out.empty())
    arguments.out = (file.parent_path() / (identify ? "identify" : "estimate")).string();
  YamlDocument document = LoadScenario(arguments, app);
  if (walk.any()) SetWalk(walk, arguments.scenario, document);
  return RunBlaming(document, [&] {
    auto scenario = document.Read<QuadrupedScenario>();
    scenario.duration_s = arguments.duration;
    const RunOptions options = OptionsOf(arguments);
    return PrintResult(RunEstimate(file, scenario, options, identify).summary, options);
  });
}

}  // namespace

ScenarioApp QuadrupedApp::AsScenarioApp() const {
  const auto read = [](const YamlDocument& document, const WalkCustomisation& customisation) {
    QuadrupedScenario scenario = ReadScenario(document, customisation);
    if (scenario.walk) CheckJudged(scenario.walk->judged_from_s, Duration(scenario));
    return scenario;
  };
  const auto run = [](const QuadrupedScenario& scenario, const RunOptions& options,
                      const WalkCustomisation& customisation) {
    return RunQuadruped(scenario, options, customisation);
  };
  return MakeApp("tenon-quadruped", "Lets a quadruped stand or walk and reports how well it did.",
                 LeggedFiles(), read, CheckQuadruped, run);
}

int QuadrupedApp::Run(int argc, char** argv) const {
  const ScenarioApp app = AsScenarioApp();
  CommandLine line(app.description, ProgramName(argv));
  CommonArguments arguments;
  AddAppArguments(line, app, arguments);
  WalkArguments walk;
  AddWalkArguments(line, walk);
  return RunMain(line, argc, argv, [&]() -> int {
    if (walk.check_realtime) {
      const auto [text, holds] = ExamineRealTime(3);
      fmt::print("{}", text);
      return holds ? kRan : kLimitBroken;
    }
    if (const auto code = RunInstead(arguments, app)) return *code;
    if (!walk.estimate.empty() || !walk.identify.empty()) return RunLog(arguments, walk, app.name);
    std::error_code ignored;
    if (std::filesystem::is_directory(arguments.replay, ignored))
      return ReplayRun(arguments, walk, app.name, customisation_);
    if (walk.compare && (!arguments.live.empty() || !arguments.replay.empty()))
      throw ParameterError("--live and --replay run one scenario: remove --compare");
    return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
      return RunCommand(LoadScenario(now, app.name), now, walk, options, customisation_);
    });
  });
}

/// The main function of tenon-quadruped.
int QuadrupedMain(int argc, char** argv) {
  return QuadrupedApp().Run(argc, argv);
}

}  // namespace tenon::apps
