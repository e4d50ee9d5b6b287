#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_keys.h>

namespace tenon::apps {

/// The keys of a scenario whose runs have a duration. Derive your own scenario from it and add its keys:
///
///     struct CartScenario : tenon::apps::AppScenario {
///       double mass_kg = 2;
///       static tenon::FieldList Fields() { return With({{"mass_kg", &CartScenario::mass_kg}}); }
///     };
///
/// Name files by members of type YamlFile, so that their paths are relative to the scenario.
struct AppScenario : CommonScenario {
  double duration_s = 10;
  double log_rate_hz = 100;  ///< sample rate of signals.csv

  /// Returns the keys of AppScenario and `own`.
  static FieldList With(FieldList own);
};

/// A key of a scenario that names a resource.
struct ScenarioFile {
  std::string key;   ///< robot
  std::string kind;  ///< robots, see FindResource()
  /// Returns the keys of such files, for their meanings; may be null.
  std::vector<ScenarioKey> (*keys)() = nullptr;
};

/// The interface of an app for campaigns. `check` and `run` may be called by several threads at once.
struct ScenarioApp {
  std::string name;         ///< value of the scenarios' key `app`; empty: any
  std::string description;  ///< text for --help
  /// Returns all keys of its scenarios.
  std::function<std::vector<ScenarioKey>()> keys;
  /// Keys that name a resource. --set can change its values.
  std::vector<ScenarioFile> files{};
  /// A shipped list of figures that --figure makes, such as "thesis" (see ThesisFigure); empty: none.
  std::string figures{};
  /// Checks a scenario without a run. Throws ParameterError.
  std::function<void(const YamlDocument& scenario)> check;
  /// Runs a scenario without random values for its own duration or `duration` [s]. Throws ParameterError with
  /// the place of an invalid value, and OutputError.
  std::function<RunResult(const YamlDocument& scenario, std::optional<double> duration,
                          const RunOptions& options)>
      run;
  /// Returns warnings on the files of a scenario, printed before a run; may be empty.
  std::function<std::vector<std::string>(const YamlDocument& scenario)> warnings{};
};

/// Makes an app of `read(document)`, which returns the scenario as a struct; `prepare(scenario)`, which makes
/// the diagram's parameters; and `run(scenario, options)`.
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

/// Makes an app whose `run` receives the scenario and calls RunScenario.
template <HasFields Scenario>
ScenarioApp MakeScenarioApp(std::string name, std::string description,
                            RunResult (*run)(const Scenario& scenario, const RunOptions& options)) {
  return MakeScenarioApp(
      std::move(name), std::move(description),
      [](const YamlDocument& document) { return document.Read<Scenario>(); }, [](const Scenario&) {}, run);
}

/// The main function of an app: reads the command line (SCENARIO, --set, --seed, --duration, --out, --graph,
/// --list, --keys, --live, --live-address, --replay, --ros2, --mcap, --version, --help), runs the scenario,
/// prints its figures and returns its exit code. Errors are printed on stderr.
int RunApp(const ScenarioApp& app, int argc, char** argv);

}  // namespace tenon::apps
