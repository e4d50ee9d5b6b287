#pragma once

#include <functional>
#include <optional>
#include <string>

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

}  // namespace tenon::apps
