#pragma once

#include <string>

#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>

namespace tenon::apps {

/// One line: robot, time, seed.
std::string Describe(const QuadrupedScenario& scenario);
/// Runs one scenario; throws KeyError and what the outputs throw.
RunResult RunQuadruped(const QuadrupedScenario& scenario, const RunOptions& options);
/// tenon-quadruped, for campaigns. A scenario with a sweep is refused: it is a campaign itself.
ScenarioApp QuadrupedApp();

}  // namespace tenon::apps
