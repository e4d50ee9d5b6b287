#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/apps/quadruped/wire_recorder.h>

namespace tenon::apps {

/// The keys of a scenario that name shipped files, and the kinds of these files.
std::vector<ScenarioFile> LeggedFiles();

/// Throws KeyError if a scenario chooses a shipped observer, but a customisation has replaced it.
void CheckObserver(const std::optional<ObserverKind>& observer, const QuadrupedWalk& loop);

/// Checks whether a scenario can be run, without running it. Throws KeyError.
void CheckQuadruped(const QuadrupedScenario& scenario, const Customisation<QuadrupedWalk>& customisation);

/// Runs one scenario, in the diagram of a walk that `customisation` changes. With a wire, a standing
/// robot is served in real time, see Serve. Throws KeyError and the errors of the outputs.
RunResult RunQuadruped(const QuadrupedScenario& scenario, const RunOptions& options,
                       const Customisation<QuadrupedWalk>& customisation = {}, const Wire& wire = {});

/// Sets the mode of a supervisor at the end, what damped the joints, and when.
void SetDeployment(const DeploymentStatus& status, Summary& summary);

}  // namespace tenon::apps
