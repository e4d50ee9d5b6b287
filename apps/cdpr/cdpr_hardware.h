#pragma once

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// The sensors of a cable robot, but for the noise of pose sensor and inertial unit, which is the scenario's
/// `noise`.
struct CdprSensors {
  std::optional<Delayed<CableSensorsParams>> cables;  ///< empty: ideal
  Delayed<PoseSensorParams> pose;                     ///< residual errors of the calibration
  Delayed<ImuErrorsParams> imu;                       ///< errors that differ from unit to unit

  static FieldList Fields();
};

/// A cable robot's hardware, in files such as plants/hardware/cdpr/standard.yaml. Values that are not given
/// are those of ideal hardware.
struct CdprHardware {
  std::string description;
  WinchErrorsParams winches;
  JitteredDelayParams<CableVector> link{.delay = 0, .unit = "N"};  ///< computation and field bus, up to 1 s
  SlowOptions calculation;                                         ///< duration of a solve of the MPC
  CdprSensors sensors;

  static FieldList Fields();
  void Validate() const { Demand(link.delay <= 1, "link.delay_s must be at most 1 s"); }
};

/// Sets the hardware of `loop`, whose robot, rates and sensor noise must be set before: shipped hardware by
/// its name, a file, or one of these with changes, see LoadResource(). Throws ParameterError.
void SetHardware(const YamlFile& what, CdprLoopParams& loop);

}  // namespace tenon::apps
