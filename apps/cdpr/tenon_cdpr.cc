// tenon-cdpr: flies a cable-driven parallel robot along a path.

#include <fmt/core.h>

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/progress.h>

namespace tenon::apps {
namespace {

Report MakeReport(const CdprScenario& scenario, const std::string& controllers) {
  return ScenarioReport(scenario, fmt::format("{} with {}, {} s, seed {}", scenario.robot, controllers,
                                              scenario.duration_s, scenario.seed));
}

/// One run, into the directory of `arguments`.
RunResult RunOnce(const CommonArguments& arguments, const CdprScenario& scenario) {
  DiagramBuilder builder;
  auto& loop =
      Blame("", [&]() -> CdprLoop& { return builder.Add<CdprLoop>("loop", MakeLoopParams(scenario)); });
  const std::vector<const Source*> faults = InsertFaults(builder, loop, scenario.faults);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, MakeSimulatorOptions(scenario));
  std::vector<const Source*> signals = CdprFigures::Signals(loop);
  const auto figures = std::make_shared<CdprFigures>(scenario.payload.release_s);
  const auto solves = std::make_shared<MpcFigures>();
  simulator.AddLog(Hz(scenario.pd.rate_hz), signals,
                   {figures, std::make_shared<ProgressSink>(scenario.duration_s)});
  if (loop.mpc != nullptr) simulator.AddLog(Hz(scenario.mpc->rate_hz), {&loop.mpc->diagnostics}, {solves});
  signals.insert(signals.end(), faults.begin(), faults.end());

  const std::string controller(EnumName(scenario.controller));
  const auto judge = [&](Summary& summary) {
    summary.Set("controller", controller);
    summary.Set("tension_min_N", figures->tension().min());
    summary.Set("tension_max_N", figures->tension().max());
    summary.Set("command_min_N", figures->command().min());
    summary.Set("command_max_N", figures->command().max());
    summary.Set("tension_rate_rms_N_per_s", figures->tension_rate().rms());
    summary.Set("euler_oscillation_rms_rad", figures->oscillation().rms());
    summary.Set("acceleration_rms_m_per_s2", figures->acceleration().rms());
    summary.Set("tracking_error_rms_m", figures->tracking_error().rms());
    summary.Set("settling_time_s", figures->settling_time());
    if (loop.mpc != nullptr) {
      summary.Set("mpc_time_median_us", Microseconds(solves->times().Quantile(0.5)));
      summary.Set("mpc_time_p99_us", Microseconds(solves->times().Quantile(0.99)));
      summary.Set("mpc_fallbacks", solves->fallbacks());
    }
  };
  return RunAndWrite(arguments, scenario, scenario.duration_s, simulator, MakeReport(scenario, controller),
                     signals, {&loop.plant.geometry, &loop.reference.geometry}, judge);
}

/// One run per controller.
int CompareControllers(const CommonArguments& arguments, CdprScenario scenario) {
  std::vector<Variant> variants;
  std::string names;
  for (const auto& [controller, name] : EnumNames(CdprController{})) {
    scenario.controller = controller;
    variants.push_back({name, [scenario](const CommonArguments& each) { return RunOnce(each, scenario); }});
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return Compare(arguments, MakeReport(scenario, names), variants);
}

int Run(const CommonArguments& arguments, const std::string& controller, bool compare) {
  if (arguments.list) {
    ListScenarios("tenon-cdpr");
    return kRan;
  }
  YamlDocument document = LoadScenario(arguments, "tenon-cdpr");
  if (!controller.empty()) document.Set("controller", controller);
  auto scenario = document.Read<CdprScenario>();
  if (arguments.seed) scenario.seed = *arguments.seed;
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunBlaming(document, [&] {
    if (compare) return CompareControllers(arguments, scenario);
    const Summary summary = RunOnce(arguments, scenario).summary;
    summary.Print();
    return summary.exit_code();
  });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Flies a cable-driven parallel robot along a path and reports how well it did.", "tenon-cdpr");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  std::string controller;
  bool compare = false;
  app.add_option("--controller", controller,
                 "mpc_equilibrium, mpc_zero or pd (the scenario's, unless given)");
  app.add_flag("--compare", compare,
               "one run per controller, each in a directory of its own below --out, and one report of all")
      ->excludes("--controller");
  return tenon::apps::RunMain(app, argc, argv,
                              [&] { return tenon::apps::Run(arguments, controller, compare); });
}
