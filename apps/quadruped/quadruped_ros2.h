#pragma once

#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/apps/quadruped/legged_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>

namespace tenon::apps {

/// Sends and records the messages of a walk, see QuadrupedMessages, and lets /cmd_vel or /joy command its
/// velocity in the range of a live run. `drive` is that of a live run, or null. `epoch` is added to the
/// stamps [s]; if it is 0, /clock has the time of the run. Adds nothing if nobody wants messages. Throws
/// KeyError of `robot`.
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedWalk& walk, WalkDrive* drive, double epoch = 0);
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedStand& stand, WalkDrive* drive = nullptr);

}  // namespace tenon::apps
