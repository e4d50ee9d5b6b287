#pragma once

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/live_session.h>
#include <tenon/apps/common/progress.h>
#include <tenon/apps/common/run_options.h>
#include <tenon/apps/common/scenario_file.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/report/report.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace tenon::apps {

/// A directory that something is written into; made if it is not there. It belongs to this process as long as
/// the object lives.
class OutputLock {
 public:
  /// Throws OutputError if the directory cannot be made, and ParameterError if another run writes into it.
  explicit OutputLock(std::filesystem::path path);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_;  ///< a descriptor; the system gives it up with the process
};

/// Whether a directory right below that of several runs may be called so: it has no '/' and no '.' first.
bool IsVariantName(std::string_view name);

/// That of a run. What an earlier run left in it is gone, and what its variants left in theirs: files of two
/// runs never stand beside each other. `files` stays, and live.jsonl, either of which may be what is run
/// again: who writes there removes them.
class OutputDirectory : public OutputLock {
 public:
  /// Throws as OutputLock does.
  explicit OutputDirectory(std::filesystem::path path);
};

/// Writes the diagram to a file, unless its name is empty: as SVG through Graphviz, or as .dot. Throws
/// ParameterError for another ending or if `dot` is missing, and OutputError.
void WriteGraph(const Diagram& diagram, const std::filesystem::path& file);

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
  void Validate() const;  ///< throws ParameterError
};

/// summary.json: the figures of a run, SI units in the keys. Starts with those that all apps have.
class Summary {
 public:
  Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome);
  /// That of a run which ended with an exit code, as Write left it. Throws RunError if the file is no
  /// summary.
  static Summary Load(const std::filesystem::path& file, int exit_code);
  Summary(Summary&&) noexcept;
  ~Summary();
  /// Null if empty: a figure of nothing is no 0.
  void Set(const std::string& key, std::optional<double> value);
  void Set(const std::string& key, std::optional<double> value, const Limits& limits) {
    Set(key, value);
    Limit(key, limits);
  }
  void Set(const std::string& key, const std::string& value);
  /// By name: of legs, of axes.
  void Set(const std::string& key, const std::vector<std::pair<std::string, std::optional<double>>>& values);

  /// Whether it went where it was told; null without a path.
  void SetFollowed(std::optional<bool> followed);
  /// A remark on the scenario, of what in it does nothing: `notes` of summary.json and of the report.
  void Note(const std::string& text) { notes_.push_back(text); }

  /// What a figure should stay within, and all that are nested in it: `limits` of summary.json, and beside
  /// the figure where it is shown.
  void Limit(const std::string& key, const Limits& limits) { limits_.emplace_back(key, limits); }
  /// What happened at `time` [s] could not have: the run is not finished, whatever end it came to, and ends
  /// with kLimitBroken. Of several the first in time is the reason, unless something else ended the run.
  void Break(double time, const std::string& reason);
  /// Whoever ran it knows better what ended it.
  void EndedBy(const std::string& reason, int exit_code);

  void Write(const std::filesystem::path& file) const;  ///< throws OutputError
  void Print() const;                                   ///< on stdout, see FigureLines
  void AddTo(Report& report) const;                     ///< the figures and the verdict
  /// Each figure by name, as text that reads back as the same value; nested ones by dotted names, "" for
  /// none.
  std::vector<std::pair<std::string, std::string>> Flat() const;
  bool finished() const;
  int exit_code() const { return exit_code_; }
  void set_exit_code(int code) { exit_code_ = code; }

  using Named = std::vector<std::pair<std::string, Summary>>;
  /// Of several runs: their names, each with its figures; throws OutputError.
  static void WriteComparison(const Named& runs, const std::filesystem::path& file);
  static void PrintComparison(const Named& runs);  ///< on stdout, see FigureColumns

 private:
  struct Json;
  Summary(std::unique_ptr<Json> json, int exit_code);
  std::unique_ptr<Json> json_;
  std::vector<std::pair<std::string, Limits>> limits_;
  std::vector<std::string> notes_;
  std::vector<std::pair<double, std::string>> breaches_;  ///< when [s], and what
  bool judged_ = false;  ///< it came to its end, and a breach is what is wrong with it
  int exit_code_;
};

/// Prints the path of report.html if there is one in the directory.
void PrintReportPath(const std::filesystem::path& directory);

/// Prints the figures of a run and the path of its report. Returns its exit code.
int PrintResult(const Summary& summary, const RunOptions& options);

/// What a run leaves; a report only if it writes files.
struct RunResult {
  Summary summary;
  std::optional<Report> report;
};

/// Sets Parameters of a diagram, by their paths. Throws KeyError with the key `parameters.PATH` if there is
/// no such Parameter or it does not take the values.
void SetParameters(Context& context, const std::map<std::string, std::vector<double>>& values);

/// A report with the title, plots, events and bands of a scenario.
Report ScenarioReport(const auto& scenario, const std::string& description,
                      const std::vector<SignalLimits>& limits = {}) {
  return Blame("report", [&] {
    return Report({.title = scenario.case_name + ": " + scenario.description,
                   .description = description,
                   .plots = scenario.report.plots,
                   .events = scenario.report.events,
                   .bands = scenario.report.bands,
                   .limits = limits,
                   .signal_rate = Hz(scenario.log_rate_hz)});
  });
}

/// The sink, off the run's thread.
std::shared_ptr<LogSink> InBackground(std::shared_ptr<LogSink> sink);

/// Whether a file could be written: kRan or, told on stderr, kOutputFailed.
int TryToWrite(const std::function<void()>& write);

/// Adds the summary to the report and writes both into a directory. What cannot be written is said on stderr,
/// and is the summary's exit code: there are still figures to print.
void WriteResults(const std::filesystem::path& directory, Summary& summary, Report& report);

/// Says the remarks on a scenario on stderr, if there are any, and which run they are of.
void SayNotes(const RunOptions& options, const std::vector<std::string>& notes);

/// Runs a scenario for `duration` [s]; `judge` sets the figures of the summary. Writes all that it leaves
/// into the directory of the options, if there is one; scenario.yaml is there from the start, so that even a
/// killed run says what it was. `signals` go to signals.csv and, with `shapes` and
/// `limits`, to the report. With a live session the run is paced to the clock, and `controls` are what
/// browsers can do to it; `parameters` of the scenario, if it has that key, are set at the start. What
/// `Notes(scenario, duration)` says of it, if there is such a function, is said before the run and in what it
/// leaves.
RunResult RunScenario(const RunOptions& options, const auto& scenario, const std::string& description,
                      double duration, Simulator& simulator, const std::vector<const Source*>& signals,
                      const std::vector<const OutputPort<Geometry>*>& shapes,
                      const std::vector<SignalLimits>& limits, const auto& judge,
                      const LiveControls& controls = {}) {
  if constexpr (requires { scenario.parameters; }) SetParameters(simulator.context(), scenario.parameters);
  const auto run = [&] {
    if (!options.live) return Advance(simulator, duration, options.wall_limit);
    LiveView view{.signals = signals,
                  .shapes = shapes,
                  .controls = controls,
                  .title = scenario.case_name + ": " + scenario.description,
                  .description = description,
                  .plots = scenario.report.plots,
                  .bands = scenario.report.bands,
                  .limits = limits};
    if constexpr (requires { scenario.parameters; }) {
      view.save = [&](const LiveSets& sets) {
        auto tuned = scenario;
        for (const LiveSet& set : sets) tuned.parameters[set.path] = set.values;
        return WriteYaml(tuned);
      };
    }
    return options.live->Advance(simulator, view, duration, options.out);
  };
  std::vector<std::string> notes;
  if constexpr (requires { Notes(scenario, duration); }) notes = Notes(scenario, duration);
  const auto advance = [&] {
    Summary summary(scenario.case_name, scenario.seed, run());
    judge(summary);
    for (const std::string& note : notes) summary.Note(note);
    return summary;
  };
  if (options.out.empty()) return {advance(), std::nullopt};

  Report report = ScenarioReport(scenario, description, limits);
  Blame("report", [&] { report.Log(simulator, signals, shapes); });
  const SignalGuard guard;              // what is written is whole, whenever a signal comes
  const ScenarioFiles files(scenario);  // read before an earlier run's go, which may be these
  const OutputDirectory out(options.out);
  std::error_code ignored;  // what cannot be removed cannot be written either, and is said so there
  if (!options.live) std::filesystem::remove(out.path() / "live.jsonl", ignored);  // else it may be replayed
  files.Write(out.path());
  SayNotes(options, notes);
  WriteGraph(simulator.context().diagram(), options.graph);
  const auto csv = std::make_shared<CsvLog>(out.path() / "signals.csv");
  std::vector<std::shared_ptr<LogSink>> sinks{InBackground(csv)};
  if (!options.live) sinks.push_back(std::make_shared<ProgressSink>(duration, options.name));
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, sinks);
  Summary summary = advance();
  WriteResults(out.path(), summary, report);
  return {std::move(summary), std::move(report)};
}

}  // namespace tenon::apps
