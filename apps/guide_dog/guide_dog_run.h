#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>

namespace tenon::apps {

/// Runs one scenario; throws KeyError and what the outputs throw.
RunResult RunGuideDog(const GuideDogScenario& scenario, const RunOptions& options);
/// tenon-guide-dog, for campaigns.
ScenarioApp GuideDogApp();

}  // namespace tenon::apps
