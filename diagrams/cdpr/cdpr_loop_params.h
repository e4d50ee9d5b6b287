#pragma once

#include <tenon/controllers/cdpr/cdpr_mpc.h>
#include <tenon/controllers/cdpr/load_estimator.h>
#include <tenon/plants/cdpr/extended_platform.h>
#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/plants/cdpr/winch_errors.h>
#include <tenon/plants/sensors/cable_sensors.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/systems/io/slow.h>
#include <tenon/systems/primitives/jittered_delay.h>

namespace tenon {

/// Imperfections of drives, links and sensors. Each optional part that has no value is ideal.
struct CdprHardwareParams {
  std::optional<JitteredDelayParams<CableVector>> command_delay;  ///< delay of the computer and the field bus
  SlowOptions calculation;  ///< duration of a solve of the MPC; its rate becomes that of the commands
  std::optional<WinchErrorsParams> winch_errors;
  std::optional<Delayed<CableSensorsParams>> cable_sensors;
  std::optional<ImuErrorsParams> imu_errors;
  int pose_delay = 0;  ///< latency of the pose sensor [samples]
  int imu_delay = 0;   ///< latency of the inertial unit [samples]
};

struct CdprLoopParams {
  CdprDescription robot;  ///< robot of the plant; the controller uses the robot of `path` as its model
  /// The path to follow. The platform starts at rest at the equilibrium of its start.
  std::shared_ptr<const EquilibriumPath> path;
  Rate control_rate = Hz(1000);  ///< rate of the reference and the PD
  DiagonalGains pd_stiffness_N_per_m = 0;
  DiagonalGains pd_damping_N_s_per_m = 0;
  std::optional<CdprMpcParams> mpc;  ///< if it has a value, the MPC replaces the PD
  bool feedforward = false;          ///< the PD follows a reference that is balanced for its acceleration
  /// Whether a LoadEstimator gives PD or MPC the load; implies feedforward. Without a value, true for an MPC
  /// with equilibrium input and false for all others.
  std::optional<bool> offset_free;
  /// Parameters of the load estimator; its robot and rate are replaced by those of `path` and `estimator`.
  /// Without a value, those of MakeLoadEstimator().
  std::optional<LoadEstimatorParams> load;
  CdprEstimatorParams estimator;
  Vec<3> start_offset = Vec<3>::Zero();  ///< offset of the platform from the start of the path [m]
  Vec<3> start_turn = Vec<3>::Zero();    ///< offset of the initial roll, pitch, yaw [rad]
  ExtendCdpr extend = {};                ///< adds to the platform in Simbody, not to the controller's model
  /// Whether the controller measures the wrench of the additions on the platform. Needs an MPC, feedforward
  /// or offset-free control.
  bool known_additions = false;
  PayloadScheduleParams payload;
  GustsParams gusts;
  std::optional<HangingLoadParams> hanging_load;  ///< a load that swings under the platform
  /// Initial horizontal displacement of the hanging load from below its attachment, shorter than the rope
  /// [m].
  Vec<3> swing = Vec<3>::Zero();
  PoseSensorParams pose_sensor;
  ImuParams imu{.rate = Hz(200)};
  CdprHardwareParams hardware;
  bool forbid_slack = true;        ///< a slack cable ends the run
  double max_tension_ratio = 1.1;  ///< a tension above this times the winches' maximum ends the run

  /// The value of `offset_free`, or its default.
  bool IsOffsetFree() const { return offset_free.value_or(mpc && mpc->equilibrium_input); }
};

}  // namespace tenon
