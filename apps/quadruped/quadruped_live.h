#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/live/live_server.h>

namespace tenon::apps {

/// The blocks that a live run of a quadruped adds: `live_drive`, which overrides the command of its walk,
/// `live_pull`, a spring that pulls a body, and `live_load`, a load that can be placed on the trunk.
class QuadrupedLive {
 public:
  /// Inserts the blocks before the diagram is built; `walk` is null for a robot that stands. Throws
  /// ParameterError if the scenario has so many forces that those of pull and load cannot be added.
  QuadrupedLive(DiagramBuilder& builder, QuadrupedWorld& world, WalkSchedule* walk,
                const LiveScenario& limits);

  /// Adds the signals to log and the shapes to show. The first entry of `shapes` must be those of the plant.
  void AddTo(std::vector<const Source*>& signals, std::vector<const OutputPort<Geometry>*>& shapes) const;
  LiveControls Controls() const;
  WalkDrive* drive() const { return drive_; }  ///< null for a robot that stands

 private:
  LiveScenario limits_;
  QuadrupedWorld& world_;
  WalkDrive* drive_ = nullptr;
  SpringPull& pull_;
  SlidingLoad& load_;
  bool acts_ = false;  ///< the plant takes forces
};

}  // namespace tenon::apps
