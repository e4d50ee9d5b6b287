#pragma once

#include <tenon/apps/common/report_scenario.h>
#include <tenon/systems/framework/diagram/diagram.h>

#include <string>
#include <vector>

namespace tenon::apps {

/// The key `log` of a scenario: signals to log in addition to those of the app.
struct LogScenario {
  /// Ports of the diagram by path, such as "loop.locomotion.swing_planner.feet"; an element selects its port
  std::vector<std::string> signals;

  static FieldList Fields() { return {{"signals", &LogScenario::signals}}; }
  void Validate() const;  ///< throws ParameterError
};

/// Adds to `signals` the ports of the diagram that a scenario names under `log.signals`, `report.plots`,
/// `report.events` and `report.bands` and that are not in `signals` yet. A name is the path of a port or a
/// state, or of a part of its value. Throws KeyError with the key and the nearest names if the diagram has no
/// such port, or if its value holds no numbers.
void AddRequested(const Diagram& diagram, const ReportScenario& report, const LogScenario& log,
                  std::vector<const Source*>& signals);

/// AddRequested for any scenario that has the key `report`, and perhaps the key `log`.
void AddRequested(const Diagram& diagram, const auto& scenario, std::vector<const Source*>& signals) {
  LogScenario log;
  if constexpr (requires { scenario.log.signals; }) log = scenario.log;
  AddRequested(diagram, scenario.report, log, signals);
}

}  // namespace tenon::apps
