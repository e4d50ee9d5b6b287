#pragma once

#include <tenon/apps/common/scenario_app.h>

namespace tenon::apps {

/// tenon-guide-dog for campaigns.
ScenarioApp GuideDogApp();

}  // namespace tenon::apps
