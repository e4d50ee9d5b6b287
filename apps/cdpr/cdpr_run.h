#pragma once

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/customisation.h>
#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/plants/cdpr/platform_pull.h>

namespace tenon::apps {

/// Returns robot, controllers, duration and seed in one line.
std::string Describe(const CdprScenario& scenario, const std::string& controllers);
/// Checks whether a scenario can be run, without running it. Throws KeyError.
void CheckCdpr(const CdprScenario& scenario, const Customisation<CdprLoop>& customisation);

/// Runs one scenario, in a diagram that `customisation` changes. Throws KeyError, and the errors of the
/// outputs.
RunResult RunCdpr(const CdprScenario& scenario, const RunOptions& options,
                  const Customisation<CdprLoop>& customisation = {});

/// Additional blocks and commands of a live run of a cable robot: `live_pull`, a spring that pulls the
/// platform, and `live_goal`, which moves it to a goal. The payload is attached and released by the loop's
/// schedule.
class CdprLive {
 public:
  /// Inserts the blocks before the diagram is built.
  CdprLive(DiagramBuilder& builder, CdprLoop& loop);
  /// Adds the signals to log.
  void AddTo(std::vector<const Source*>& signals) const { signals.push_back(&pull_.wrench); }
  /// Returns the commands for the live page, on which the plant's shapes must come first.
  LiveControls Controls() const;

 private:
  LiveControls::Goal Goal() const;

  CdprLoop& loop_;
  PlatformPull& pull_;
  GoalPath& goal_;
  bool acts_ = false;  ///< the plant takes forces, and has the parameters that tell its weight
};

}  // namespace tenon::apps
