#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/progress.h>
#include <tenon/systems/framework/diagram.h>
#include <tenon/systems/report/report.h>

namespace tenon::apps {

/// The directory that a run writes into; made if it is not there. Holds scenario.yaml from the start, so that
/// even a killed run says what it was.
class OutputDirectory {
 public:
  /// Throws ParameterError if the directory cannot be made or written.
  OutputDirectory(const CommonArguments& arguments, const std::string& scenario_yaml);
  const std::filesystem::path& path() const { return path_; }
  /// Writes the diagram to the file of --graph, if there is one: as SVG through Graphviz, or as .dot. Throws
  /// ParameterError for another ending, or if the file cannot be written or `dot` is missing.
  void WriteGraph(const Diagram& diagram) const;

 private:
  std::filesystem::path path_;
  std::filesystem::path graph_;
};

/// The part of a scenario that says what its report shows.
struct ReportScenario {
  std::vector<Plot> plots;          ///< with names of signals as in signals.csv
  std::vector<std::string> events;  ///< signals of which every change is marked
  std::vector<Band> bands;          ///< modes

  static FieldList Fields() {
    return {{"plots", &ReportScenario::plots},
            {"events", &ReportScenario::events},
            {"bands", &ReportScenario::bands}};
  }
};

/// summary.json: the figures of a run, SI units in the keys. Starts with those that all apps have.
class Summary {
 public:
  Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome);
  Summary(Summary&&) noexcept;
  ~Summary();
  void Set(const std::string& key, double value);
  void Set(const std::string& key, const std::string& value);
  /// By name: of legs, of axes.
  void Set(const std::string& key, const std::vector<std::pair<std::string, double>>& values);
  /// Null if empty.
  void Set(const std::string& key, const std::optional<double>& value);

  void Write(const std::filesystem::path& file) const;  ///< throws RunError
  void Print() const;                                   ///< on stdout, one figure a line
  void AddTo(Report& report) const;                     ///< the figures and the verdict
  ExitCode exit_code() const { return exit_code_; }

  using Named = std::vector<std::pair<std::string, Summary>>;
  /// Of several runs: their names, each with its figures; throws RunError.
  static void WriteComparison(const Named& runs, const std::filesystem::path& file);
  static void PrintComparison(const Named& runs);  ///< on stdout, one figure a line, one run a column

 private:
  struct Json;
  std::unique_ptr<Json> json_;
  ExitCode exit_code_;
};

/// What a run leaves.
struct RunResult {
  Summary summary;
  Report report;
};

/// A report with the title, plots, events and bands of a scenario.
Report ScenarioReport(const auto& scenario, const std::string& description) {
  return Report({.title = scenario.case_name + ": " + scenario.description,
                 .description = description,
                 .plots = scenario.report.plots,
                 .events = scenario.report.events,
                 .bands = scenario.report.bands,
                 .signal_rate = Hz(scenario.log_rate_hz)});
}

/// Runs a scenario for `duration` [s] and writes all that it leaves into the directory of `arguments`.
/// `signals` go to signals.csv and, with `shapes`, to the report; `judge` sets the figures of the summary.
RunResult RunAndWrite(const CommonArguments& arguments, const auto& scenario, double duration,
                      Simulator& simulator, Report report, const std::vector<const Source*>& signals,
                      const std::vector<const OutputPort<Geometry>*>& shapes, const auto& judge) {
  report.Log(simulator, signals, shapes);
  const OutputDirectory out(arguments, WriteYaml(scenario));
  out.WriteGraph(simulator.context().diagram());
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, {std::make_shared<CsvLog>(out.path() / "signals.csv")});
  const RunOutcome outcome = Advance(simulator, duration);

  Summary summary(scenario.case_name, scenario.seed, outcome);
  judge(summary);
  summary.Write(out.path() / "summary.json");
  summary.AddTo(report);
  report.Write(out.path() / "report.html");
  return {std::move(summary), std::move(report)};
}

}  // namespace tenon::apps
