#pragma once

#include <tenon/apps/common/scenario_file.h>
#include <tenon/systems/report/report.h>

namespace tenon::apps {

/// The key `report` of a scenario: the contents of its report.
struct ReportScenario {
  /// Signals are named as in signals.csv, or by the paths of other ports; norm:, rate: and xy: derive curves.
  std::vector<Plot> plots;
  std::vector<std::string> events;  ///< signals whose changes are marked
  std::vector<Band> bands;          ///< signals whose values are shown as coloured bands, such as modes

  static FieldList Fields() {
    return {{"plots", &ReportScenario::plots},
            {"events", &ReportScenario::events},
            {"bands", &ReportScenario::bands}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The plots of a scenario, followed by others.
std::vector<Plot> PlotsOf(const ReportScenario& scenario, const std::vector<Plot>& others);

/// Makes a report with the title, plots, events and bands of a scenario, and further plots.
Report ScenarioReport(const auto& scenario, const std::string& description,
                      const std::vector<SignalLimits>& limits = {}, const std::vector<Plot>& plots = {}) {
  return Blame("report", [&] {
    return Report({.title = scenario.case_name + ": " + scenario.description,
                   .description = description,
                   .plots = PlotsOf(scenario.report, plots),
                   .events = scenario.report.events,
                   .bands = scenario.report.bands,
                   .limits = limits,
                   .signal_rate = Hz(scenario.log_rate_hz)});
  });
}

/// The key `log` of a scenario: signals to log in addition to those of the app.
struct LogScenario {
  /// Ports of the diagram by path, such as "loop.locomotion.swing_planner.feet"; an element selects its port
  std::vector<std::string> signals;

  static FieldList Fields() { return {{"signals", &LogScenario::signals}}; }
  void Validate() const;  ///< throws ParameterError
};

/// The keys that the scenarios of all apps have.
struct CommonScenario {
  std::string app;                                        ///< name of the app that runs the scenario
  std::string description;                                ///< description of the scenario in one line
  std::string case_name;                                  ///< title of the run
  std::uint64_t seed = 1;                                 ///< seed of all random streams
  ReportScenario report;                                  ///< contents of the report
  LogScenario log;                                        ///< signals to log in addition to those of the app
  std::map<std::string, std::vector<double>> parameters;  ///< Parameters of the diagram to set, by path

  /// Returns these keys, with `own` behind those that name the scenario.
  static FieldList With(const FieldList& own);
};

/// Adds to `signals` the ports of the diagram that a scenario names under `log.signals`, `report.plots`,
/// `report.events` and `report.bands` and that are not in `signals` yet. A name is the path of a port or a
/// state, or of a part of its value. Throws KeyError with the key and the nearest names if the diagram has no
/// such port, or if its value holds no numbers.
void AddRequested(const Diagram& diagram, const CommonScenario& scenario,
                  std::vector<const Source*>& signals);

}  // namespace tenon::apps
