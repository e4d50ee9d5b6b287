#pragma once

#include <tenon/apps/common/link_scenario.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

#include <optional>
#include <string>

namespace tenon::apps {

/// @file
/// The keys of a cable robot's hardware, in files such as plants/hardware/cdpr/standard.yaml. Values that are
/// not given are those of ideal hardware. The noise of pose sensor and inertial unit is the scenario's
/// `noise`.

/// Errors of the winches, see WinchErrors.
struct WinchScenario {
  double gain_deviation = 0;  ///< standard deviation of the torque constants
  double ripple_ratio = 0;    ///< standard deviation of the torque ripple, relative to the tension
  double friction_ratio = 0;  ///< dry friction over tension
  double friction_speed_m_per_s = 0.005;  ///< cable speed at which the friction reaches 76 % of its bound

  static FieldList Fields();
};

/// Encoders on the drums and load cells, see CableSensors.
struct CableSensorScenario {
  std::optional<double> rate_hz;  ///< sample rate; empty: 1000 Hz
  int latency_samples = 0;        ///< delay of the output
  double resolution_m = 0;        ///< resolution of the lengths; 0: ideal
  double offset_m = 0;            ///< standard deviation of the constant error of each length
  /// Cut-off of the low-pass filter of the rates, which are differences of lengths; 0: ideal rates.
  double rate_bandwidth_hz = 0;
  double tension_noise_ratio = 0;  ///< standard deviation of the noise, relative to the tension
  double tension_offset_N = 0;     ///< standard deviation of the constant error of each load cell

  static FieldList Fields();
};

/// Residual errors of the pose sensor's calibration, see PoseSensor.
struct PoseHardwareScenario {
  int latency_samples = 0;
  double offset_m = 0;    ///< standard deviation along each axis
  double offset_rad = 0;  ///< standard deviation about each axis

  static FieldList Fields();
};

/// Standard deviations of errors between units of the same type, see ImuErrors.
struct ImuHardwareScenario {
  int latency_samples = 0;
  double angular_velocity_bias_deviation_rad_per_s = 0;
  double acceleration_bias_deviation_m_per_s2 = 0;
  double angular_velocity_walk_rad_per_s_per_sqrt_s = 0;
  double acceleration_walk_m_per_s2_per_sqrt_s = 0;
  double misalignment_rad = 0;

  static FieldList Fields();
};

struct CdprSensorsScenario {
  CableSensorScenario cables;
  PoseHardwareScenario pose;
  ImuHardwareScenario imu;

  static FieldList Fields();
};

struct CdprHardwareScenario {
  std::string description;
  WinchScenario winches;
  LinkScenario link;
  CdprSensorsScenario sensors;

  static FieldList Fields();
};

/// Reads shipped hardware by its name, a file, or one of these with overrides, see LoadResource(). Throws
/// ParameterError.
CdprHardwareScenario LoadCdprHardware(const YamlFile& what);
/// Sets the hardware of `loop`, whose robot, rates and sensor noise must be set before.
void SetHardware(const CdprHardwareScenario& hardware, CdprLoopParams& loop);

}  // namespace tenon::apps
