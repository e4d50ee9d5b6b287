#pragma once

#include <tenon/apps/common/run_options.h>
#include <tenon/apps/common/scenario_app.h>

#include <optional>

namespace tenon::apps {

/// Name and keys of tenon-observer-order. It has neither `check` nor `run`: see StudyObserverOrders.
ScenarioApp ObserverOrderApp();

/// Runs a scenario once for each of its variants, each into a directory of its own, and writes and prints a
/// comparison. `duration` [s] overrides that of the scenario. Returns the exit code. Throws ParameterError
/// with the place of a value that is not possible, and the errors of the outputs.
int StudyObserverOrders(const YamlDocument& document, std::optional<double> duration,
                        const RunOptions& options);

}  // namespace tenon::apps
