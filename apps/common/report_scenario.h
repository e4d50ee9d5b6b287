#pragma once

#include <tenon/apps/common/blame.h>
#include <tenon/systems/report/report.h>

#include <string>
#include <vector>

namespace tenon::apps {

/// The key `report` of a scenario: the contents of its report.
struct ReportScenario {
  std::vector<Plot> plots;          ///< signals are named as in signals.csv, or by the paths of other ports
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

}  // namespace tenon::apps
