#pragma once

#include <tenon/apps/common/scenario_app.h>

#include <optional>
#include <string>

namespace tenon::apps {

/// tenon-quadruped for campaigns. It refuses a scenario with a sweep, which is a campaign itself.
ScenarioApp QuadrupedApp();

/// The options of tenon-quadruped's command line that change a walk.
struct WalkArguments {
  std::string gait;             ///< gait of all segments that walk; empty: those of the scenario
  std::optional<double> speed;  ///< forward speed of all segments that move forward or backward [m/s]
  std::string observer;         ///< name of an ObserverKind; empty: the scenario's
  bool compare = false;         ///< one run for each observer

  bool any() const { return !gait.empty() || speed || !observer.empty() || compare; }
};

/// Runs a scenario with the options of the command line: once, or its sweep, or once for each observer.
/// `duration` [s] overrides that of the scenario, and `name` is the scenario's in messages. Returns the exit
/// code. Throws ParameterError with the place of a value that is not possible, and the errors of the outputs.
int RunWalkCommand(YamlDocument document, const std::string& name, const WalkArguments& walk,
                   std::optional<double> duration, const RunOptions& options);

}  // namespace tenon::apps
