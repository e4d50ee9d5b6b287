#pragma once

#include <tenon/apps/common/run_options.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/live/live_server.h>

#include <vector>

namespace tenon::apps {

/// What a live run of a quadruped has besides: the blocks `live_drive`, which takes the wheel of its walk,
/// `live_pull`, a hand that pulls at it, and `live_load`, which is dropped on its trunk.
class QuadrupedLive {
 public:
  /// Inserts the blocks before the diagram is built; `walk` may be null. Throws ParameterError if forces of
  /// the scenario leave no room for those of pull and load.
  QuadrupedLive(DiagramBuilder& builder, QuadrupedWorld& world, WalkSchedule* walk,
                const LiveScenario& limits);

  /// Adds what is to be logged and shown. The plant's shapes come first among `shapes`.
  void AddTo(std::vector<const Source*>& signals, std::vector<const OutputPort<Geometry>*>& shapes) const;
  LiveControls Controls() const;

 private:
  LiveScenario limits_;
  QuadrupedWorld& world_;
  WalkDrive* drive_ = nullptr;
  SpringPull& pull_;
  SlidingLoad& load_;
};

}  // namespace tenon::apps
