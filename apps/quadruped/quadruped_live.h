#pragma once

#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/plants/legged/spring_pull.h>

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

/// Sends and records the messages of a walk, see QuadrupedMessages, and lets /cmd_vel or /joy command its
/// velocity in the range of a live run. `drive` is that of a live run, or null. Joints, IMU and foot forces
/// are recorded at the rates of their sensors. For a robot, `wire` has the rate of its sensors and the epoch
/// that is added to the stamps; without it, /clock has the time of the run, and /ground_truth the true state
/// of a run with an estimator. Adds nothing if nobody wants messages. Throws KeyError of `robot`.
struct RobotTimes {
  Rate rate;
  double epoch = 0;  ///< [s]
};
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedWalk& walk, WalkDrive* drive, const std::optional<RobotTimes>& wire = {});
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedStand& stand, WalkDrive* drive = nullptr);

}  // namespace tenon::apps
