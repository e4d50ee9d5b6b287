#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

/// Defaults: those of WalkSchedule, and a change of height that takes about a second.
struct WalkDriveParams {
  double acceleration = 0.5;    ///< [m/s^2]
  double yaw_acceleration = 1;  ///< [rad/s^2]
  double height_bandwidth = 5;  ///< w of a change of height [rad/s]
  Gait gait = Gait::kTrot;      ///< until another one is ordered
  Rate rate = Hz(100);

  void Validate() const;  ///< throws ParameterError
};

/// How far a WalkDrive has come with what was ordered; what is commanded, or what is added to the plan.
struct DriveProgress {
  bool active = false;               ///< it is commanded
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

/// Takes the wheel of a walk: hands on what a schedule commands until it is active, and from then on what its
/// Parameters order, as the robot can follow it.
///
///     ports in    planned   a WalkCommand; standing if not connected
///     port out    command   sampled
///     parameters  active    whether the orders below are followed
///                 velocity  forward, left [m/s], yaw rate [rad/s]
///                 gait      of walking
///                 stands    instead of walking, once the robot has slowed down
///                 height    of the CoM above the nominal one [m]
///
/// Velocities change by the accelerations of the params at most, forward and left along the straight line
/// between them. The height h goes over to the one ordered, h*, as
///
///     h'' = w^2 (h* - h) - 2 w h',
///
/// which does not overshoot; explicit Euler's step of it at every tick. Taking the wheel or giving it back,
/// no velocity jumps that the schedule does not let jump: what differs from the plan goes to zero in the same
/// way.
class WalkDrive final : public LeafSystem<WalkDriveParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> planned{this, {"planned"}, WalkCommand{}};
  Parameter<bool> active{this, {"active"}, false, "whether the orders are followed, or the plan"};
  Parameter<Vec<3>> velocity{this,
                             {"velocity", "m/s, m/s, rad/s", "forward,left,yaw"},
                             Vec<3>::Zero(),
                             "ordered, in the frame of the heading"};
  Parameter<Gait> gait{this, {"gait"}, params.gait, "of walking"};
  Parameter<bool> stands{this, {"stands"}, false, "instead of walking"};
  Parameter<double> height{this, {"height", "m"}, 0, "of the CoM above the nominal one"};
  Scratch<DriveProgress> progress{this, "progress"};
  OutputPort<WalkCommand> command{this,
                                  {"command"},
                                  Sampled{params.rate},
                                  Uses(planned, active, velocity, gait, stands, height, progress),
                                  &WalkDrive::CalcCommand};

 private:
  WalkCommand CalcCommand(const WalkCommand& planned, bool active, const Vec<3>& velocity, Gait gait,
                          bool stands, double height, DriveProgress& progress) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::DriveProgress);
