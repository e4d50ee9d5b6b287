// tenon-quadruped: a quadruped that stands, drops, or walks.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/quadruped/quadruped_app.h>

int main(int argc, char** argv) {
  using namespace tenon::apps;
  const ScenarioApp app = QuadrupedApp();
  CLI::App line(app.description, app.name);
  CommonArguments arguments;
  AddCommonArguments(line, arguments);
  AddLiveArguments(line, arguments);
  WalkArguments walk;
  line.add_option("--gait", walk.gait, "crawl, trot, pace or gallop (the scenario's, unless given)");
  line.add_option("--speed", walk.speed, "forward speed [m/s] (the scenario's, unless given)");
  line.add_option("--observer", walk.observer,
                  "none, legs, com, hybrid, focchi, ndo_m or ndo_inverse (the scenario's, unless given)");
  line.add_flag("--compare", walk.compare,
                "one run for each observer, each in its own directory below --out, and one report of all")
      ->excludes("--observer");
  return RunMain(line, argc, argv, [&]() -> int {
    if (PrintsInstead(arguments, app)) return kRan;
    if (walk.compare && (!arguments.live.empty() || !arguments.replay.empty()))
      throw tenon::ParameterError("--live and --replay run one scenario: remove --compare");
    return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
      return RunWalkCommand(LoadScenario(now, app.name), now.scenario, walk, now.duration, options);
    });
  });
}
