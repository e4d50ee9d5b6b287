// tenon-cdpr: flies a cable-driven parallel robot along a path.

#include <tenon/apps/cdpr/cdpr_run.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/apps/common/run_scenario.h>

namespace tenon::apps {
namespace {

/// One run per controller.
int CompareControllers(const RunOptions& options, CdprScenario scenario) {
  std::vector<Variant> variants;
  std::string names;
  for (const auto& [controller, name] : EnumNames(CdprController{})) {
    scenario.controller = controller;
    variants.push_back({name, [scenario](const RunOptions& each) { return RunCdpr(scenario, each); }});
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return Compare(options, ScenarioReport(scenario, Describe(scenario, names)), variants);
}

int RunOnce(const CommonArguments& arguments, const std::string& controller, bool compare,
            const RunOptions& options) {
  YamlDocument document = LoadScenario(arguments, "tenon-cdpr");
  if (!controller.empty()) document.Set("controller", controller);
  auto scenario = document.Read<CdprScenario>();
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunBlaming(document, [&] {
    if (compare) return CompareControllers(options, scenario);
    return PrintResult(RunCdpr(scenario, options).summary, options);
  });
}

int Run(const CommonArguments& arguments, const std::string& controller, bool compare) {
  if (PrintsInstead(arguments, CdprApp())) return kRan;
  if (compare && (!arguments.live.empty() || !arguments.replay.empty()))
    throw ParameterError("--live and --replay run one controller: remove --compare");
  return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
    return RunOnce(now, controller, compare, options);
  });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app(tenon::apps::CdprApp().description, "tenon-cdpr");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  tenon::apps::AddLiveArguments(app, arguments);
  std::string controller;
  bool compare = false;
  app.add_option(
      "--controller", controller,
      "mpc_equilibrium, mpc_zero, pd, pd_feedforward or pd_offset_free (the scenario's, unless given)");
  app.add_flag("--compare", compare,
               "one run per controller, each in a directory of its own below --out, and one report of all")
      ->excludes("--controller");
  return tenon::apps::RunMain(app, argc, argv,
                              [&] { return tenon::apps::Run(arguments, controller, compare); });
}
