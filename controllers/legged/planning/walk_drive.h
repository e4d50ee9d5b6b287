#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/ros2/velocity_command.h>

namespace tenon {

/// The default accelerations are those of WalkSchedule; a change of height takes about one second.
struct WalkDriveParams {
  double acceleration = 0.5;    ///< [m/s^2]
  double yaw_acceleration = 1;  ///< [rad/s^2]
  double height_bandwidth = 5;  ///< w, bandwidth of a change of height [rad/s]
  Gait gait = Gait::kTrot;      ///< initial gait
  Rate rate = Hz(100);

  void Validate() const;  ///< throws ParameterError
};

/// State of a WalkDrive: the present command while active, the remaining difference to the plan otherwise.
struct DriveProgress {
  bool active = false;               ///< true while `active` of the block is set
  Vec<3> velocity = Vec<3>::Zero();  ///< forward, left [m/s], yaw rate [rad/s]
  double height = 0;                 ///< [m]
  double height_rate = 0;            ///< [m/s]

  static FieldList Fields() {
    return {{"active", &DriveProgress::active},
            {"velocity", &DriveProgress::velocity},
            {"height", &DriveProgress::height, "m"},
            {"height_rate", &DriveProgress::height_rate, "m/s"}};
  }
};

/// Overrides a planned walk: passes on the commands of a schedule, and while `active` is set, commands that
/// follow its Parameters within acceleration limits. An active `request` counts as if `active` were set, with
/// its velocity and without `stands`. Without `planned` the plan is to stand.
///
/// Accelerations are limited by the params; forward and left velocities change along a straight line. The
/// height h follows the commanded height h* by
///
///     h'' = w^2 (h* - h) - 2 w h',
///
/// which is critically damped, discretised by the explicit Euler method. When `active` changes, velocities do
/// not jump beyond those of the schedule: the difference to the plan decays in the same way.
class WalkDrive final : public LeafSystem<WalkDriveParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> planned{this, {"planned"}, WalkCommand{}};
  InputPort<VelocityCommand> request{this, {"request"}, VelocityCommand{}};
  Parameter<bool> active{this, {"active"}, false, "if set, the parameters override the planned command"};
  Parameter<Vec<3>> velocity{this,
                             {"velocity", "m/s, m/s, rad/s", "forward,left,yaw"},
                             Vec<3>::Zero(),
                             "commanded velocity, in the frame of the heading"};
  Parameter<Gait> gait{this, {"gait"}, params.gait, "gait while moving"};
  Parameter<bool> stands{this, {"stands"}, false, "stand instead of walking"};
  Parameter<double> height{this, {"height", "m"}, 0, "height of the CoM above the nominal one"};
  Scratch<DriveProgress> progress{this, "progress"};
  OutputPort<WalkCommand> command{this,
                                  {"command"},
                                  Sampled{params.rate},
                                  Uses(planned, request, active, velocity, gait, stands, height, progress),
                                  &WalkDrive::CalcCommand};

 private:
  WalkCommand CalcCommand(const WalkCommand& planned, const VelocityCommand& request, bool active,
                          const Vec<3>& velocity, Gait gait, bool stands, double height,
                          DriveProgress& progress) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::DriveProgress);
