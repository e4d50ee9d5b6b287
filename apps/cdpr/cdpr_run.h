#pragma once

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/run_scenario.h>

namespace tenon::apps {

/// Returns robot, controllers, duration and seed in one line.
std::string Describe(const CdprScenario& scenario, const std::string& controllers);
/// Checks whether a scenario can be run, without running it. Throws KeyError.
void CheckCdpr(const CdprScenario& scenario, const Customisation<CdprLoop>& customisation);

/// Runs one scenario, in a diagram that `customisation` changes. Throws KeyError, and the errors of the
/// outputs.
RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options,
                  const Customisation<CdprLoop>& customisation = {});

}  // namespace tenon::apps
