#pragma once

#include <tenon/apps/common/link_scenario.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

#include <optional>
#include <string>

namespace tenon::apps {

/// @file
/// Hardware of a cable robot in scenarios, from files such as plants/hardware/cdpr/standard.yaml. Keys
/// without a value are ideal. The noise of pose sensor and inertial unit is the scenario's `noise`.

/// Errors of the winches, see WinchErrors.
struct WinchScenario {
  double gain_deviation = 0;
  double ripple_ratio = 0;
  double friction_ratio = 0;  ///< dry friction over tension
  double friction_speed_m_per_s = 0.005;

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

/// Encoders on the drums and load cells, see CableSensors.
struct CableSensorScenario {
  std::optional<double> rate_hz;  ///< 1000
  int latency_samples = 0;
  double resolution_m = 0;
  double offset_m = 0;           ///< standard deviation, by cable
  double rate_bandwidth_hz = 0;  ///< 0: rates are measured
  double tension_noise_ratio = 0;
  double tension_offset_N = 0;  ///< standard deviation, by load cell

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

/// Residual errors of the pose sensor's calibration, see PoseSensor.
struct PoseHardwareScenario {
  int latency_samples = 0;
  double offset_m = 0;    ///< standard deviation along each axis
  double offset_rad = 0;  ///< standard deviation about each axis

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
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
  void Validate() const;  ///< throws ParameterError
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
