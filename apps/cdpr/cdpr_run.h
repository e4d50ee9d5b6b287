#pragma once

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_app.h>

#include <string>

namespace tenon::apps {

/// One line with robot, controllers, duration and seed.
std::string Describe(const CdprScenario& scenario, const std::string& controllers);
/// Runs one scenario. Throws KeyError, and the errors of the outputs.
RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options);
/// The app tenon-cdpr, for campaigns.
ScenarioApp CdprApp();

}  // namespace tenon::apps
