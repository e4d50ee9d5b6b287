#pragma once

#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/apps/quadruped/legged_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>

namespace tenon::apps {

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
