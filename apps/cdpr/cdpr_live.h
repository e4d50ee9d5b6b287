#pragma once

#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/live/live_server.h>

#include <vector>

namespace tenon::apps {

/// What a live run of a cable robot has besides: the blocks `live_pull`, a hand that pulls at the platform,
/// and `live_goal`, which leads it elsewhere. Its payload is hung on and off by the schedule that is there.
class CdprLive {
 public:
  /// Inserts the blocks before the diagram is built.
  CdprLive(DiagramBuilder& builder, CdprLoop& loop);
  /// Adds what is to be logged.
  void AddTo(std::vector<const Source*>& signals) const { signals.push_back(&pull_.wrench); }
  /// The plant's shapes come first.
  LiveControls Controls() const;

 private:
  LiveControls::Goal Goal() const;

  CdprLoop& loop_;
  PlatformPull& pull_;
  GoalPath& goal_;
};

}  // namespace tenon::apps
