#pragma once

#include <tenon/controllers/joint_pd.h>
#include <tenon/plants/disturbances.h>
#include <tenon/plants/fall_monitor.h>
#include <tenon/plants/force_sensors.h>
#include <tenon/plants/imu.h>
#include <tenon/plants/joint_encoders.h>
#include <tenon/plants/quadruped_plant.h>
#include <tenon/systems/diagram_builder.h>

#include <vector>

namespace tenon {

struct QuadrupedStandParams {
  QuadrupedPlantParams plant;
  JointPdParams pd;
  JointEncodersParams encoders;
  ForceSensorParams torque_sensor;
  ForceSensorParams foot_sensor;
  ImuParams imu;
  std::vector<PulseForceParams> pulses;  ///< together with the others no more than kMaxExternalForces
  std::vector<SineForceParams> sines;
  std::vector<RandomForceParams> random;
  double min_height = 0;  ///< of the trunk above the ground; below, the robot has fallen [m]
  double max_tilt = 1;    ///< of the trunk; above, the robot has fallen [rad]
};

/// A quadruped that holds its stance by joint PD,
///
///                disturbances ──┐
///                               ▼
///     pd ──────────────────► plant ──► encoders, torque_sensor, foot_sensor, imu
///      ▲                                  │
///      └──────────────────────────────────┘ joint angles and speeds
///
/// watched by a fall monitor. The blocks are public, for logs and for taking it apart.
class QuadrupedStand final : public Subdiagram {
 public:
  explicit QuadrupedStand(const QuadrupedStandParams& params);

  JointPd& pd;
  QuadrupedPlant& plant;
  JointEncoders& encoders;
  JointTorqueSensor& torque_sensor;
  FootForceSensor& foot_sensor;
  TrunkImu& imu;
  ForceBundle& disturbances;

  OutputPort<LeggedState> state{this, {"state"}};
};

}  // namespace tenon
