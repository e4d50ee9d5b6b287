#pragma once

#include <memory>

#include "tenon/controllers/cable_pd.h"
#include "tenon/controllers/equilibrium_path.h"
#include "tenon/controllers/reference_generator.h"
#include "tenon/plants/cdpr_plant.h"
#include "tenon/plants/imu.h"
#include "tenon/plants/payload_schedule.h"
#include "tenon/plants/pose_sensor.h"
#include "tenon/plants/slack_monitor.h"
#include "tenon/systems/diagram_builder.h"

namespace tenon {

struct CdprLoopParams {
  CdprDescription robot;  ///< the plant's; the controller believes what `path` was made for
  /// What the platform is to follow; it starts at rest at the equilibrium of the path's start.
  std::shared_ptr<const EquilibriumPath> path;
  Rate control_rate = Hz(1000);  ///< of the reference and the PD
  double pd_stiffness_N_per_m = 0;
  double pd_damping_N_s_per_m = 0;
  PayloadScheduleParams payload;
  PoseSensorParams pose_sensor;
  ImuParams imu;
  bool forbid_slack = true;  ///< end the run when a cable goes slack
};

/// A cable robot under its length controller (Morlando 2023, section 3.5.2):
///
///     reference ──► pd ──► plant ──► pose_sensor, imu
///                    ▲       │
///                    └───────┘ cable lengths
///
/// Its outputs are those of the blocks; the blocks themselves are public, for logs and for taking it apart.
class CdprLoop final : public Subdiagram {
 public:
  explicit CdprLoop(const CdprLoopParams& params);

  ReferenceGenerator& reference;
  CablePd& pd;
  PayloadSchedule& payload;
  CdprPlant& plant;
  PoseSensor& pose_sensor;
  Imu& imu;

  OutputPort<PlatformState> platform{this, {"platform"}};
  OutputPort<CableSignals> cables{this, {"cables"}};
  OutputPort<PoseMeasurement> pose{this, {"pose"}};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};
};

}  // namespace tenon
