#pragma once

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_app.h>

#include <string>

namespace tenon::apps {

/// One line: robot, its controllers, time, seed.
std::string Describe(const CdprScenario& scenario, const std::string& controllers);
/// Runs one scenario; throws KeyError and what the outputs throw.
RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options);
/// tenon-cdpr, for campaigns.
ScenarioApp CdprApp();

}  // namespace tenon::apps
