#pragma once

#include <tenon/apps/common/link_scenario.h>
#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

#include <Eigen/Core>

#include <optional>
#include <string>

namespace tenon::apps {

/// @file
/// The keys of a quadruped's hardware, in files such as plants/hardware/legged/standard.yaml, and of its
/// sensors, in scenarios too. Values that are not given are those of ideal hardware. Noise is white and given
/// by its standard deviation. Each sensor has a random stream of its own, which depends on the run's seed and
/// the sensor's name.

/// Encoders of the joints, see JointEncoders.
struct EncoderScenario {
  std::optional<double> rate_hz;                ///< sample rate; empty: 1000 Hz
  std::optional<int> latency_samples;           ///< delay of the output
  std::optional<double> angle_noise_rad;        ///< standard deviation
  std::optional<double> angle_bias_rad;         ///< bias, equal at all joints
  std::optional<double> speed_noise_rad_per_s;  ///< standard deviation
  std::optional<double> speed_bias_rad_per_s;   ///< bias, equal at all joints
  std::optional<int> bits;                      ///< resolution of one turn of the joint; empty: ideal
  std::optional<double> offset_rad;             ///< standard deviation of the calibration error of a joint
  std::optional<double> speed_bandwidth_hz;     ///< cut-off of the low-pass filter of the speeds, which are
                                                ///< differences of angles; empty: ideal speeds

  static FieldList Fields();
};

/// Torque sensors of the joints. Their noise is proportional to the signal.
struct TorqueSensorScenario {
  std::optional<double> rate_hz;       ///< sample rate; empty: 1000 Hz
  std::optional<int> latency_samples;  ///< delay of the output
  std::optional<double> noise_ratio;   ///< standard deviation, relative to the torque
  std::optional<double> bias_N_m;      ///< bias, equal at all joints

  static FieldList Fields();
};

/// Sensors of the ground forces on the feet.
struct FootForceSensorScenario {
  std::optional<double> rate_hz;       ///< sample rate; empty: 1000 Hz
  std::optional<int> latency_samples;  ///< delay of the output
  std::optional<double> noise_ratio;   ///< standard deviation of each component, relative to the component
  std::optional<double>
      noise_weight_ratio;        ///< standard deviation of each component, relative to the robot's weight
  std::optional<double> bias_N;  ///< bias, equal in all components of all feet
  /// Threshold below which a force is measured as 0, relative to the robot's weight.
  std::optional<double> threshold_weight_ratio;
  /// Axes of the sensors. Forces in the axes of the shanks are rotated by the estimated state. Without
  /// sensors the forces are estimated from the joint torques.
  std::optional<FootSensing> mounted;

  static FieldList Fields();
};

/// Inertial unit on the trunk, which measures angular velocity and specific force.
struct ImuScenario {
  std::optional<double> rate_hz;                                   ///< sample rate; empty: 1000 Hz
  std::optional<int> latency_samples;                              ///< delay of the output
  std::optional<double> angular_velocity_noise_rad_per_s;          ///< standard deviation
  std::optional<Eigen::Vector3d> angular_velocity_bias_rad_per_s;  ///< bias in the trunk's frame
  std::optional<double> acceleration_noise_m_per_s2;               ///< standard deviation
  std::optional<Eigen::Vector3d> acceleration_bias_m_per_s2;       ///< bias in the trunk's frame
  // Standard deviations of errors that differ from unit to unit, see ImuErrors.
  /// Standard deviation of a constant bias, drawn for each run.
  std::optional<double> angular_velocity_bias_deviation_rad_per_s;
  /// Standard deviation of a constant bias, drawn for each run.
  std::optional<double> acceleration_bias_deviation_m_per_s2;
  std::optional<double> angular_velocity_walk_rad_per_s_per_sqrt_s;  ///< random walk of the bias
  std::optional<double> acceleration_walk_m_per_s2_per_sqrt_s;       ///< random walk of the bias
  std::optional<double> misalignment_rad;  ///< standard deviation of the rotation about each axis

  static FieldList Fields();
};

struct SensorScenario {
  EncoderScenario encoders;
  TorqueSensorScenario torque;
  FootForceSensorScenario foot_force;
  ImuScenario imu;

  static FieldList Fields();
};

/// Data of all drives. Torques are relative to those of the robot.
struct DriveScenario {
  /// Peak torque over rotor inertia, both at the joint; empty: from the robot's file.
  std::optional<double> rotor_acceleration_rad_per_s2;
  std::optional<double> friction_ratio;  ///< dry friction over peak torque; empty: from the robot's file
  /// Viscous friction at the speed limit over peak torque; empty: from the robot's file.
  std::optional<double> damping_ratio;
  double gain_deviation = 0;           ///< standard deviation of the torque constants, see DriveErrors
  double ripple_ratio = 0;             ///< amplitude of the torque ripple, see DriveErrors
  std::optional<double> bandwidth_hz;  ///< bandwidth of the torque; empty: ideal
  bool limit_speed = false;            ///< limits the torque by the torque-speed line

  static FieldList Fields();
};

struct HardwareScenario {
  std::string description;
  DriveScenario drives;
  LinkScenario link;
  SensorScenario sensors;

  static FieldList Fields();
};

/// Reads shipped hardware, a file, or one with changes (see LoadResource). Throws ParameterError.
HardwareScenario LoadHardware(const YamlFile& file);
/// The hardware with its sensors overridden, key by key.
HardwareScenario WithSensors(HardwareScenario hardware, const SensorScenario& sensors);

/// Sets the hardware in a world whose robot is set. `rate` is the sample rate of the controller.
void SetHardware(const HardwareScenario& hardware, Rate rate, QuadrupedWorldParams& world);
/// The noise in the model of a state estimator: that of the data sheets, with lower bounds above zero.
ContactAidedNoise BelievedNoise(const HardwareScenario& hardware);

}  // namespace tenon::apps
