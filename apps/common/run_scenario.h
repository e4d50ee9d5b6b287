#pragma once

#include <tenon/apps/common/output_directory.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/summary.h>
#include <tenon/systems/simulation/background_log.h>
#include <tenon/systems/simulation/real_time_thread.h>

#include <system_error>

namespace tenon::apps {

/// Exit codes of all apps. A run that a signal stops returns 128 plus the number of the signal: 130 after
/// Ctrl-C, 143 after SIGTERM.
enum ExitCode {
  kRan = 0,
  kBadUsage = 2,          ///< command line, scenario or robot file
  kLimitBroken = 3,       ///< the robot fell, broke a forbidden limit, or exceeded physical limits
  kNumericalFailure = 4,  ///< includes lack of memory
  kOutputFailed = 5,      ///< a file could not be written
};

/// Options of a run: its output and its time limit.
struct RunOptions {
  std::filesystem::path out;              ///< directory; empty: no files and no progress
  std::string name = {};                  ///< shown with the progress, such as "run 3 of 64"; may be empty
  std::string graph = {};                 ///< file of the diagram's graph; empty: none
  std::optional<double> wall_limit = {};  ///< limit of the wall-clock time [s]
  /// Steers the run by browsers or a recording; may be null.
  std::shared_ptr<LiveSession> live = {};
  /// Sends messages of ROS 2, "INTERFACE[,DOMAIN]" or kAnyInterface; empty: none. The run keeps real time.
  std::optional<std::string> ros2 = {};
  bool mcap = false;  ///< records these messages in run.mcap
  /// The run has a RealTimeThread on this processor; empty: none.
  std::optional<int> processor = {};
};
inline constexpr const char* kAnyInterface = "any";

/// The results of a run; without a report if the run writes no files.
struct RunResult {
  Summary summary;
  std::optional<Report> report;
};

/// Prints the path of report.html if the directory holds one.
void PrintReportPath(const std::filesystem::path& directory);

/// Prints the figures of a run and the path of its report. Returns its exit code.
int PrintResult(const Summary& summary, const RunOptions& options);

/// Sets Parameters of a diagram by their paths. Throws KeyError with the key `parameters.PATH` if there is no
/// such Parameter or it refuses the values.
void SetParameters(Context& context, const std::map<std::string, std::vector<double>>& values);

/// Runs the sink in its own thread, see BackgroundLog.
std::shared_ptr<LogSink> InBackground(std::shared_ptr<LogSink> sink);

/// Calls `write`, prints its error on stderr and returns kRan or the exit code of the error.
int TryToWrite(const std::function<void()>& write);

/// Adds the summary to the report and writes both into a directory. If a file cannot be written, the error is
/// printed on stderr and becomes the summary's exit code, so that the figures can still be printed.
void WriteResults(const std::filesystem::path& directory, Summary& summary, Report& report);

/// Prints the remarks on a scenario on stderr, with the name of the run.
void PrintNotes(const RunOptions& options, const std::vector<std::string>& notes);

/// Runs a scenario for `duration` [s]; `judge` sets the figures of the summary. Writes all files into the
/// output directory of the options, if there is one; it writes scenario.yaml first, so that even a killed run
/// can be identified. `signals`, and those that the scenario names (see AddRequested), are written to
/// signals.csv and, with `shapes` and `limits`, to the report. A live session keeps the run in real time, and
/// browsers can use `controls`. Sets `parameters` of the scenario before the run. If a function
/// `Notes(scenario)` exists, its remarks are printed before the run and added to the results. `plots` follow
/// those of the scenario, which is derived from CommonScenario.
RunResult RunScenario(const RunOptions& options, const auto& scenario, const std::string& description,
                      double duration, Simulator& simulator, std::vector<const Source*> signals,
                      const std::vector<const OutputPort<Geometry>*>& shapes,
                      const std::vector<SignalLimits>& limits, const auto& judge,
                      const LiveControls& controls = {}, const std::vector<Plot>& plots = {}) {
  SetParameters(simulator.context(), scenario.parameters);
  if (options.live || !options.out.empty()) AddRequested(simulator.context().diagram(), scenario, signals);
  const auto run = [&] {
    if (!options.live) return Advance(simulator, duration, options.wall_limit);
    LiveView view{.signals = signals,
                  .shapes = shapes,
                  .controls = controls,
                  .title = scenario.case_name + ": " + scenario.description,
                  .description = description,
                  .plots = PlotsOf(scenario.report, plots),
                  .bands = scenario.report.bands,
                  .limits = limits};
    view.save = [&](const LiveSets& sets) {
      auto tuned = scenario;
      for (const LiveSet& set : sets) tuned.parameters[set.path] = set.values;
      return WriteYaml(tuned);
    };
    return options.live->Advance(simulator, view, duration, options.out);
  };
  std::vector<std::string> notes;
  if constexpr (requires { Notes(scenario); }) notes = Notes(scenario);
  const auto advance = [&] {
    std::optional<RealTimeThread> real_time;
    if (options.processor) {
      real_time.emplace(*options.processor);
      PrintNotes(options, real_time->refused());
      notes.insert(notes.end(), real_time->refused().begin(), real_time->refused().end());
    }
    Summary summary(scenario.case_name, scenario.seed, run());
    judge(summary);
    for (const std::string& note : notes) summary.Note(note);
    return summary;
  };
  if (options.out.empty()) return {advance(), std::nullopt};

  Report report = ScenarioReport(scenario, description, limits, plots);
  Blame("report", [&] { report.Log(simulator, signals, shapes); });
  const SignalGuard guard;              // a signal does not interrupt the writing of files
  const ScenarioFiles files(scenario);  // may be the files of an earlier run, which are removed next
  const OutputDirectory out(options.out);
  std::error_code ignored;
  if (!options.live) std::filesystem::remove(out.path() / "live.jsonl", ignored);
  if (!options.mcap) std::filesystem::remove(out.path() / "run.mcap", ignored);
  files.Write(out.path());
  PrintNotes(options, notes);
  WriteGraph(simulator.context().diagram(), options.graph);
  std::vector<std::shared_ptr<LogSink>> sinks;
  if (!options.live) sinks.push_back(std::make_shared<ProgressSink>(duration, options.name));
  sinks.push_back(std::make_shared<CsvLog>(out.path() / "signals.csv"));
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, {std::make_shared<BackgroundLog>(sinks)});
  Summary summary = advance();
  WriteResults(out.path(), summary, report);
  return {std::move(summary), std::move(report)};
}

/// One of several runs, which writes into the directory that its options name.
struct Variant {
  std::string name;
  std::function<RunResult(const RunOptions&)> run;
};

/// Runs all variants, each into a subdirectory of its name, and writes one summary.json with the figures of
/// each variant and one report.html of the first kReported variants. `report` has their title and plots. A
/// signal or a full disk stops all runs. Returns the largest exit code. Throws ParameterError if two variants
/// have the same name.
int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants);
inline constexpr std::size_t kReported = 8;

}  // namespace tenon::apps
