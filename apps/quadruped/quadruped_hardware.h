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
/// What scenarios say of a quadruped's hardware, in files such as plants/hardware/legged/standard.yaml and,
/// of the sensors, in themselves. What is not given is that of ideal hardware. Noise is white, its standard
/// deviation given; every sensor draws from a stream of its own, which follows from the run's seed and the
/// sensor's name.

/// How the angles of the joints are measured, see JointEncoders.
struct EncoderScenario {
  std::optional<double> rate_hz;                ///< 1000
  std::optional<int> latency_samples;           ///< so many samples late
  std::optional<double> angle_noise_rad;        ///< standard deviation
  std::optional<double> angle_bias_rad;         ///< the same at all joints
  std::optional<double> speed_noise_rad_per_s;  ///< standard deviation
  std::optional<double> speed_bias_rad_per_s;   ///< the same at all joints
  std::optional<int> bits;                      ///< of a turn of the joint; without: any angle
  std::optional<double> offset_rad;             ///< standard deviation of the calibration, by joint
  std::optional<double> speed_bandwidth_hz;     ///< speeds are differences of angles, through a low-pass

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

/// The noise grows with the signal: 0.1 is 10 % of it.
struct TorqueSensorScenario {
  std::optional<double> rate_hz;       ///< 1000
  std::optional<int> latency_samples;  ///< so many samples late
  std::optional<double> noise_ratio;   ///< 0.1 is 10 % of the torque
  std::optional<double> bias_N_m;      ///< the same at all joints

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

/// The forces of the ground on the feet, as sensors there measure them.
struct FootForceSensorScenario {
  std::optional<double> rate_hz;             ///< 1000
  std::optional<int> latency_samples;        ///< so many samples late
  std::optional<double> noise_ratio;         ///< of each component: 0.1 is 10 % of it
  std::optional<double> noise_weight_ratio;  ///< of each component, over the robot's weight
  std::optional<double> bias_N;              ///< the same in all components of all feet
  std::optional<double>
      threshold_weight_ratio;  ///< smaller forces are measured as 0; over the robot's weight
  /// In the shank's axes they are turned by what the robot knows; without sensors the leg observer tells
  /// them.
  std::optional<FootSensing> mounted;

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

/// The inertial unit on the trunk: angular velocity and specific force.
struct ImuScenario {
  std::optional<double> rate_hz;                                   ///< 1000
  std::optional<int> latency_samples;                              ///< so many samples late
  std::optional<double> angular_velocity_noise_rad_per_s;          ///< standard deviation
  std::optional<Eigen::Vector3d> angular_velocity_bias_rad_per_s;  ///< in the trunk's frame
  std::optional<double> acceleration_noise_m_per_s2;               ///< standard deviation
  std::optional<Eigen::Vector3d> acceleration_bias_m_per_s2;       ///< in the trunk's frame
  // Standard deviations of what one unit has and the next has not, see ImuErrors.
  std::optional<double>
      angular_velocity_bias_deviation_rad_per_s;  ///< standard deviation of the bias that a run draws
  std::optional<double>
      acceleration_bias_deviation_m_per_s2;  ///< standard deviation of the bias that a run draws
  std::optional<double> angular_velocity_walk_rad_per_s_per_sqrt_s;  ///< of the bias, a random walk
  std::optional<double> acceleration_walk_m_per_s2_per_sqrt_s;       ///< of the bias, a random walk
  std::optional<double> misalignment_rad;  ///< standard deviation of the axes, about each of them

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

struct SensorScenario {
  EncoderScenario encoders;
  TorqueSensorScenario torque;
  FootForceSensorScenario foot_force;
  ImuScenario imu;

  static FieldList Fields();
};

/// Of all drives; torques over each robot's own.
struct DriveScenario {
  /// Peak torque over the rotor's inertia, both seen at the joint; without: what the robot's file says.
  std::optional<double> rotor_acceleration_rad_per_s2;
  std::optional<double>
      friction_ratio;  ///< dry friction over peak torque; without: what the robot's file says
  std::optional<double> damping_ratio;  ///< viscous friction at the speed limit, over peak torque; likewise
  double gain_deviation = 0;            ///< of the torque constants, see DriveErrors
  double ripple_ratio = 0;
  std::optional<double> bandwidth_hz;  ///< of the torque; without: at once
  bool limit_speed = false;            ///< the torque falls with speed

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

struct HardwareScenario {
  std::string description;
  DriveScenario drives;
  LinkScenario link;
  SensorScenario sensors;

  static FieldList Fields();
};

/// Reads the hardware that ships under a name, or a file, or one with what differs (LoadResource). Throws
/// ParameterError.
HardwareScenario LoadHardware(const YamlFile& what);
/// With the sensors that a scenario says instead, key by key.
HardwareScenario WithSensors(HardwareScenario hardware, const SensorScenario& sensors);

/// Puts it into a world whose robot is set. `rate` is that of the controller.
void SetHardware(const HardwareScenario& hardware, Rate rate, QuadrupedWorldParams& world);
/// The noise that an estimator may believe in who knows the data sheets; none is perfect.
ContactAidedNoise BelievedNoise(const HardwareScenario& hardware);

}  // namespace tenon::apps
