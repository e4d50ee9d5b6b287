#include <tenon/apps/cdpr/cdpr_run.h>

#include <fmt/core.h>

#include <memory>
#include <optional>
#include <vector>

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/tally.h>
#include <tenon/systems/framework/diagram_builder.h>

namespace tenon::apps {

std::string Describe(const CdprScenario& scenario, const std::string& controllers) {
  return fmt::format("{} with {}, {} s, seed {}", scenario.robot, controllers, scenario.duration_s,
                     scenario.seed);
}

RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options) {
  DiagramBuilder builder;
  auto& loop =
      Blame("", [&]() -> CdprLoop& { return builder.Add<CdprLoop>("loop", MakeLoopParams(scenario)); });
  const std::vector<const Source*> faults = InsertFaults(builder, loop, scenario.faults);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, MakeSimulatorOptions(scenario));
  std::vector<const Source*> signals = CdprFigures::Signals(loop);
  const auto figures = std::make_shared<CdprFigures>(scenario.payload.attach_s, scenario.payload.release_s);
  const auto solves = std::make_shared<MpcFigures>();
  simulator.AddLog(Hz(scenario.pd.rate_hz), signals, {figures});
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
    summary.Set("loaded_error_rms_m", figures->loaded_error().rms());
    summary.Set("loaded_swing_rms_rad", figures->loaded_swing());
    summary.Set("settling_time_s", figures->settling_time());
    if (loop.mpc != nullptr) {
      summary.Set("mpc_time_median_us", Microseconds(solves->times().Quantile(0.5)));
      summary.Set("mpc_time_p99_us", Microseconds(solves->times().Quantile(0.99)));
      summary.Set("mpc_fallbacks", solves->fallbacks());
    }
  };
  return RunScenario(options, scenario, Describe(scenario, controller), scenario.duration_s, simulator,
                     signals, {&loop.plant.geometry, &loop.reference.geometry}, judge);
}

ScenarioApp CdprApp() {
  return MakeScenarioApp(
      "tenon-cdpr", [](const YamlDocument& document) { return document.Read<CdprScenario>(); },
      MakeLoopParams, RunCdpr);
}

}  // namespace tenon::apps
