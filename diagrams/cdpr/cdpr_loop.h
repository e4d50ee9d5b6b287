#pragma once

#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_mpc.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/controllers/cdpr/load_estimator.h>
#include <tenon/controllers/cdpr/reference_balancer.h>
#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/plants/cdpr/winch_errors.h>
#include <tenon/plants/sensors/cable_sensors.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/primitives/jittered_delay.h>

#include <memory>
#include <optional>
#include <string>

namespace tenon {

/// What lies between a controller and an ideal plant with ideal sensors; what is not given is not there.
struct CdprHardwareParams {
  std::optional<JitteredDelayParams<CableVector>> command_delay;  ///< computing and field bus
  std::optional<WinchErrorsParams> winch_errors;
  std::optional<CableSensorsParams> cable_sensors;
  std::optional<ImuErrorsParams> imu_errors;
  // How many samples old the sensors' values are when they arrive.
  int cable_delay = 0;  ///< of cable_sensors
  int pose_delay = 0;
  int imu_delay = 0;
};

struct CdprLoopParams {
  CdprDescription robot;  ///< the plant's; the controller believes what `path` was made for
  /// What the platform is to follow; it starts at rest at the equilibrium of the path's start.
  std::shared_ptr<const EquilibriumPath> path;
  Rate control_rate = Hz(1000);  ///< of the reference and the PD
  double pd_stiffness_N_per_m = 0;
  double pd_damping_N_s_per_m = 0;
  std::optional<CdprMpcParams> mpc;  ///< if given, it drives the robot, from `estimator`, in place of the PD
  bool feedforward = false;          ///< the PD knows what accelerates the platform
  /// Whether PD or MPC are told the load by a LoadEstimator; implies feedforward. Without a value an MPC with
  /// equilibrium input is, all others are not.
  std::optional<bool> offset_free;
  /// Of the robot that `path` was made for, at the estimator's rate; without: see MakeLoadEstimator.
  std::optional<LoadEstimatorParams> load;
  CdprEstimatorParams estimator;
  Vec<3> start_offset = Vec<3>::Zero();  ///< of the platform from the start of the path [m]
  Vec<3> start_turn = Vec<3>::Zero();    ///< added to roll, pitch, yaw there [rad]
  PayloadScheduleParams payload;
  GustsParams gusts;
  /// If given, a load swings under the platform; at the start it hangs `swing` aside of straight down.
  std::optional<HangingLoadParams> hanging_load;
  Vec<3> swing = Vec<3>::Zero();  ///< horizontal, shorter than the rope [m]
  PoseSensorParams pose_sensor;
  ImuParams imu{.rate = Hz(200)};
  CdprHardwareParams hardware;
  bool forbid_slack = true;        ///< end the run when a cable goes slack,
  double max_tension_ratio = 1.1;  ///< or is pulled harder than this times the winches' maximum
};

/// The load estimator of an MPC has the defaults of LoadEstimatorParams. That of a PD has bandwidths of
/// 3 rad/s: from 5 rad/s on, cables go slack when the load of D2 is released.
LoadEstimatorParams MakeLoadEstimator(bool mpc);

/// A cable robot under its length controller (Morlando 2023, section 3.5.2),
///
///     reference ──► pd ──► plant ──► pose_sensor, imu
///                    ▲       │
///                    └───────┘ cable lengths
///
/// or under its model predictive controller (section 3.4), which knows the reference beforehand:
///
///     mpc ──► plant ──► pose_sensor, imu ──► estimator ──┐
///      ▲                                                 │
///      └─────────────────────────────────────────────────┘ pose and velocity
///
/// of which the estimator is told the cables' lengths besides.
///
/// The PD may follow what ReferenceBalancer makes of the reference, with feedforward; and either may be told
/// the load on the platform by LoadEstimator, which sees it by estimator, inertial unit and the cables'
/// tensions, so that a constant one leaves no error. All but the plain PD do without cables that
/// BrokenCableDetector finds broken.
///
/// Gusts and a hanging load act on the plant's wrench.
///
/// With hardware, what it says lies between: command_delay and winch_errors before the plant, cable_sensors,
/// imu_errors and delays behind it. Its outputs are those of the blocks; the blocks themselves are public,
/// for logs and for taking it apart.
class CdprLoop final : public Subdiagram {
 public:
  explicit CdprLoop(const CdprLoopParams& params);

  ReferenceGenerator& reference;
  CablePd* pd = nullptr;               ///< this one,
  CdprMpc* mpc = nullptr;              ///< or this one,
  CdprEstimator* estimator = nullptr;  ///< which needs this, as what is offset-free does
  LoadEstimator* load = nullptr;
  BrokenCableDetector* broken_cables = nullptr;  ///< of all but the plain PD
  ReferenceBalancer* balancer = nullptr;
  PayloadSchedule& payload;
  CdprPlant& plant;
  Gusts* gusts = nullptr;               ///< if there are any
  HangingLoad* hanging_load = nullptr;  ///< if there is one
  PoseSensor& pose_sensor;
  Imu& imu;

  // Where the controller ends and begins: what takes its command, and what it is told.
  InputPort<CableVector>* drive = nullptr;
  const OutputPort<CableSignals>* told_cables = nullptr;
  const OutputPort<PoseMeasurement>* told_pose = nullptr;
  const OutputPort<ImuMeasurement>* told_inertial = nullptr;

  OutputPort<CableVector> command{this, {"command", "N"}};  ///< of the controller
  OutputPort<PlatformState> platform{this, {"platform"}};
  OutputPort<CableSignals> cables{this, {"cables"}};        ///< the true ones
  OutputPort<PoseMeasurement> pose{this, {"pose"}};         ///< as the controller is told
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};  ///< likewise

 private:
  void AddHardware(const CdprLoopParams& params);
  void AddDisturbances(const CdprLoopParams& params);
};

}  // namespace tenon
