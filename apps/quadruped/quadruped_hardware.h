#pragma once

#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/io/slow.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// Data of all drives. Torques are relative to those of the robot.
struct DriveRatings : DriveErrorsParams {
  /// Peak torque over rotor inertia, both at the joint; empty: from the robot's file.
  std::optional<double> rotor_acceleration;
  std::optional<double> friction_ratio;  ///< dry friction over peak torque; empty: from the robot's file
  /// Viscous friction at the speed limit over peak torque; empty: from the robot's file.
  std::optional<double> damping_ratio;
  std::optional<double> bandwidth;  ///< bandwidth of the torque; empty: ideal
  bool limit_speed = false;         ///< limits the torque by the torque-speed line

  static FieldList Fields();
};

/// A quadruped's hardware, in files such as plants/hardware/legged/standard.yaml. Values that are not given
/// are those of ideal hardware.
struct QuadrupedHardware {
  std::string description;
  DriveRatings drives;
  JitteredDelayParams<Vec<12>> link{.delay = 0, .unit = "N m"};  ///< computation and field bus, up to 1 s
  SlowOptions calculation;                                       ///< duration of a solve of the MPC
  QuadrupedSensors sensors;

  static FieldList Fields();
  void Validate() const { Demand(link.delay <= 1, "link.delay_s must be at most 1 s"); }
};

/// Changes to the sensors of a QuadrupedHardware.
using SensorChanges = YamlChanges<QuadrupedSensors, true>;

/// Reads shipped hardware, a file, or one with changes (see LoadResource), with `sensors` changed, for a
/// robot of this scale. Throws ParameterError.
QuadrupedHardware LoadHardware(const YamlFile& file, const Scale& scale, const SensorChanges& sensors = {});

/// Sets the hardware in a world whose robot is set. `rate` is the sample rate of the controller.
/// The duration of calculations goes to `mpc`; without predictive control, which is null, it is an error.
void SetHardware(const QuadrupedHardware& hardware, Rate rate, QuadrupedWorldParams& world,
                 SlowOptions* mpc = nullptr);
/// The noise in the model of a state estimator: that of the data sheets, with lower bounds above zero.
ContactAidedNoise BelievedNoise(const QuadrupedSensors& sensors);

}  // namespace tenon::apps
