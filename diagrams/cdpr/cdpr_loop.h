#pragma once

#include <memory>
#include <optional>

#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_mpc.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/systems/framework/diagram_builder.h>

namespace tenon {

struct CdprLoopParams {
  CdprDescription robot;  ///< the plant's; the controller believes what `path` was made for
  /// What the platform is to follow; it starts at rest at the equilibrium of the path's start.
  std::shared_ptr<const EquilibriumPath> path;
  Rate control_rate = Hz(1000);  ///< of the reference and the PD
  double pd_stiffness_N_per_m = 0;
  double pd_damping_N_s_per_m = 0;
  std::optional<CdprMpcParams> mpc;  ///< if given, it drives the robot, from `estimator`, in place of the PD
  CdprEstimatorParams estimator;
  Vec<3> start_offset = Vec<3>::Zero();  ///< of the platform from the start of the path [m]
  Vec<3> start_turn = Vec<3>::Zero();    ///< added to roll, pitch, yaw there [rad]
  PayloadScheduleParams payload;
  PoseSensorParams pose_sensor;
  ImuParams imu;
  bool forbid_slack = true;        ///< end the run when a cable goes slack,
  double max_tension_ratio = 1.1;  ///< or is pulled harder than this times the winches' maximum
};

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
/// Its outputs are those of the blocks; the blocks themselves are public, for logs and for taking it apart.
class CdprLoop final : public Subdiagram {
 public:
  explicit CdprLoop(const CdprLoopParams& params);

  ReferenceGenerator& reference;
  CablePd* pd = nullptr;               ///< this one,
  CdprEstimator* estimator = nullptr;  ///< or these two
  CdprMpc* mpc = nullptr;
  PayloadSchedule& payload;
  CdprPlant& plant;
  PoseSensor& pose_sensor;
  Imu& imu;

  OutputPort<CableVector> command{this, {"command", "N"}};  ///< of the controller
  OutputPort<PlatformState> platform{this, {"platform"}};
  OutputPort<CableSignals> cables{this, {"cables"}};
  OutputPort<PoseMeasurement> pose{this, {"pose"}};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};
};

}  // namespace tenon
