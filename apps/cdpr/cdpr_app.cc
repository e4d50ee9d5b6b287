#include <tenon/apps/cdpr/cdpr_app.h>
#include <tenon/apps/cdpr/cdpr_run.h>
#include <tenon/apps/common/command_line.h>

namespace tenon::apps {
namespace {

using CdprCustomisation = Customisation<CdprLoop>;

/// One run per controller, and one of the customisation.
int CompareControllers(const RunOptions& options, const CdprScenario& scenario,
                       const CdprCustomisation& customisation) {
  std::vector<Variant> variants;
  std::string names;
  const auto add = [&](const std::string& name, const CdprScenario& run, const CdprCustomisation& change) {
    variants.push_back({name, [run, change](const RunOptions& each) { return RunCdpr(run, each, change); }});
    names += (names.empty() ? "" : ", ") + name;
  };
  if (customisation) add(kMine, scenario, customisation);  // first, because the page opens with the first run
  CdprScenario shipped = scenario;
  shipped.custom.reset();
  for (const auto& [controller, name] : EnumNames(CdprController{})) {
    shipped.controller = controller;
    add(name, shipped, {});
  }
  return Compare(options, ScenarioReport(scenario, Describe(scenario, names)), variants);
}

int RunOnce(const CommonArguments& arguments, const std::string& controller, bool compare,
            const RunOptions& options, const CdprCustomisation& customisation) {
  YamlDocument document = LoadScenario(arguments, "tenon-cdpr");
  if (!controller.empty()) document.Set("controller", controller);
  return RunBlaming(document, [&] {
    auto scenario = customisation.ReadScenario<CdprScenario>(document);
    if (arguments.duration) scenario.duration_s = *arguments.duration;
    if (compare) return CompareControllers(options, scenario, customisation);
    return PrintResult(RunCdpr(scenario, options, customisation).summary, options);
  });
}

}  // namespace

ScenarioApp CdprApp::AsScenarioApp() const {
  const auto read = [](const YamlDocument& document, const CdprCustomisation& customisation) {
    return customisation.ReadScenario<CdprScenario>(document);
  };
  return MakeApp(
      "tenon-cdpr", "Flies a cable-driven parallel robot along a path and reports how well it did.",
      {{"robot", "robots", &KeysOf<CdprDescription>}, {"profile", "profiles"}, {"hardware", "hardware/cdpr"}},
      read, CheckCdpr, RunCdpr);
}

int CdprApp::Run(int argc, char** argv) const {
  const ScenarioApp app = AsScenarioApp();
  CommandLine line(app.description, ProgramName(argv));
  CommonArguments arguments;
  AddAppArguments(line, app, arguments);
  std::string controller;
  bool compare = false;
  line.Add("--controller", &controller,
           "mpc_equilibrium, mpc_zero, mpc_thesis, lqr, pd, pd_feedforward or pd_offset_free (default: "
           "the scenario's)");
  line.Add("--compare", &compare,
           "make one run for each controller, each in its own directory below --out, and one report of all",
           {.excludes = "--controller"});
  return RunMain(line, argc, argv, [&]() -> int {
    if (const auto code = RunInstead(arguments, app)) return *code;
    if (compare && (!arguments.live.empty() || !arguments.replay.empty()))
      throw ParameterError("--live and --replay run one controller: remove --compare");
    return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
      return RunOnce(now, controller, compare, options, customisation_);
    });
  });
}

/// The main function of tenon-cdpr.
int CdprMain(int argc, char** argv) {
  return CdprApp().Run(argc, argv);
}

}  // namespace tenon::apps
