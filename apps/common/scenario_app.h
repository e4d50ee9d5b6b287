#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// An app as campaigns see it: what turns a scenario into figures. Both functions may be called by several
/// threads at once.
struct ScenarioApp {
  std::string name;  ///< that of the scenarios' key `app`
  /// Throws ParameterError if the scenario is none of this app's; runs nothing.
  std::function<void(const YamlDocument& scenario)> check;
  /// Runs a scenario in which nothing is left to chance, for its own time or `duration` [s]. Throws
  /// ParameterError with the place of what cannot be had, and what the outputs throw.
  std::function<RunResult(const YamlDocument& scenario, std::optional<double> duration,
                          const RunOptions& options)>
      run;
};

/// That of `read(document)`, the scenario as a struct; `prepare(scenario)`, which makes the diagram's
/// parameters; and `run(scenario, options)`.
ScenarioApp MakeScenarioApp(std::string name, auto read, auto prepare, auto run) {
  return {.name = std::move(name),
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

}  // namespace tenon::apps
