#pragma once

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/run_options.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_keys.h>
#include <tenon/systems/yaml/yaml.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// What the scenarios of all apps say. A scenario of one's own derives from it and adds its keys:
///
///     struct CartScenario : tenon::apps::AppScenario {
///       double mass_kg = 2;
///       static tenon::FieldList Fields() { return With({{"mass_kg", &CartScenario::mass_kg}}); }
///     };
///
/// Files are named by members of type YamlFile, so that their paths start from the scenario.
struct AppScenario {
  std::string app;          ///< the app whose scenario this is
  std::string description;  ///< one line
  std::string case_name;    ///< title of the run
  double duration_s = 10;
  std::uint64_t seed = 1;    ///< of all random streams
  double log_rate_hz = 100;  ///< of signals.csv
  ReportScenario report;     ///< what the report shows; all signals if it says nothing
  std::map<std::string, std::vector<double>> parameters;  ///< of the diagram, by path: set at the start

  /// The keys of these, then `own`.
  static FieldList With(FieldList own);
};

/// An app as campaigns see it: what turns a scenario into figures. `check` and `run` may be called by several
/// threads at once.
struct ScenarioApp {
  std::string name;         ///< that of the scenarios' key `app`
  std::string description;  ///< what it does, for --help
  /// All keys of its scenarios.
  std::function<std::vector<ScenarioKey>()> keys;
  /// Those that name a shipped file of a kind, whose values --set may set as well: robot, robots.
  std::vector<std::pair<std::string, std::string>> files{};
  /// Throws ParameterError if the scenario is none of this app's; runs nothing.
  std::function<void(const YamlDocument& scenario)> check;
  /// Runs a scenario in which nothing is left to chance, for its own time or `duration` [s]. Throws
  /// ParameterError with the place of what cannot be had, and what the outputs throw.
  std::function<RunResult(const YamlDocument& scenario, std::optional<double> duration,
                          const RunOptions& options)>
      run;
  /// What of the files of a scenario is not taken as it stands, told before a run; may be left out.
  std::function<std::vector<std::string>(const YamlDocument& scenario)> warnings{};
};

/// That of `read(document)`, the scenario as a struct; `prepare(scenario)`, which makes the diagram's
/// parameters; and `run(scenario, options)`.
ScenarioApp MakeScenarioApp(std::string name, std::string description, auto read, auto prepare, auto run) {
  using Scenario = decltype(read(std::declval<const YamlDocument&>()));
  return {.name = std::move(name),
          .description = std::move(description),
          .keys = [] { return KeysOf<Scenario>(); },
          .check =
              [=](const YamlDocument& document) {
                RunBlaming(document, [&] {
                  const auto scenario = read(document);
                  Blame("", [&] { prepare(scenario); });
                });
              },
          .run =
              [=](const YamlDocument& document, std::optional<double> duration, const RunOptions& options) {
                return RunBlaming(document, [&] {
                  auto scenario = read(document);
                  if (duration) scenario.duration_s = *duration;
                  return run(scenario, options);
                });
              }};
}

/// An app of one's own: `run` gets its scenario, and calls RunScenario.
template <HasFields Scenario>
ScenarioApp MakeScenarioApp(std::string name, std::string description,
                            RunResult (*run)(const Scenario& scenario, const RunOptions& options)) {
  return MakeScenarioApp(
      std::move(name), std::move(description),
      [](const YamlDocument& document) { return document.Read<Scenario>(); }, [](const Scenario&) {}, run);
}

/// A main(): reads the command line (SCENARIO, --set, --seed, --duration, --out, --graph, --list, --keys,
/// --live, --live-address, --replay, --version, --help), runs the scenario, prints its figures and returns
/// its exit code. What goes wrong is told on stderr.
int RunApp(const ScenarioApp& app, int argc, char** argv);

}  // namespace tenon::apps
