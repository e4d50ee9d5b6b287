#pragma once

#include <tenon/plants/legged/disturbances.h>
#include <tenon/plants/legged/drive_errors.h>
#include <tenon/plants/legged/fall_monitor.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/plants/legged/sliding_load.h>
#include <tenon/plants/sensors/force_sensors.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/joint_encoders.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/primitives/held_lag.h>
#include <tenon/systems/primitives/jittered_delay.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// Where the forces on the feet are measured.
enum class FootSensing {
  kWorld,  ///< they come in W
  kShank,  ///< in the shanks, and come in their axes
  kNone,   ///< nowhere: there is no `foot_forces`
};
constexpr auto EnumNames(FootSensing) {
  return std::array{Named{FootSensing::kWorld, "world"}, Named{FootSensing::kShank, "shank"},
                    Named{FootSensing::kNone, "none"}};
}

/// What lies between a controller and an ideal plant with ideal sensors; what is not given is not there.
struct QuadrupedHardwareParams {
  std::optional<JitteredDelayParams<Vec<12>>> command_delay;  ///< computing and field bus
  std::optional<DriveErrorsParams> drive_errors;
  std::optional<HeldLagParams<Vec<12>>> drive_lag;
  std::optional<ImuErrorsParams> imu_errors;
  FootSensing foot_sensing = FootSensing::kWorld;
  // How many samples old the sensors' values are when they arrive.
  int encoder_delay = 0;
  int torque_delay = 0;
  int foot_delay = 0;
  int imu_delay = 0;
};

/// The trunk's height at which a robot has fallen, over that of its nominal stance.
inline constexpr double kFallHeightRatio = 0.5;

struct QuadrupedWorldParams {
  QuadrupedPlantParams plant;
  JointEncodersParams encoders;
  ForceSensorParams torque_sensor;
  FootForceSensorParams foot_sensor;
  /// Its place is the robot's. Without errors, as the other sensors are.
  ImuParams imu{.angular_velocity_noise = Vec<3>::Zero(), .specific_force_noise = Vec<3>::Zero()};
  QuadrupedHardwareParams hardware;
  std::optional<SlidingLoadParams> sliding_load;  ///< its start is the plant's
  std::vector<PulseForceParams> pulses;  ///< with the others and `pull` no more than kMaxExternalForces
  std::vector<SineForceParams> sines;
  std::vector<RandomForceParams> random;
  double min_height = 0;   ///< of the trunk above the ground; below, the robot has fallen [m]
  double max_tilt = 1;     ///< of the trunk; above, the robot has fallen [rad]
  double max_height = 10;  ///< of the trunk above the ground; no robot flies [m]
};

/// The robot at rest in its nominal stance on the ground at the origin of W, without disturbances.
/// Throws ParameterError if it cannot stand there, see StandingOn.
QuadrupedWorldParams MakeQuadrupedWorld(const QuadrupedDescription& robot, const TerrainParams& terrain = {});

/// Everything of a quadruped's run that is not the controller's: the robot on its terrain, its sensors, the
/// forces that disturb it, and a monitor that ends the run when it falls.
///
///     pull, disturbances ──► plant ──► encoders, torque_sensor, foot_sensor, imu ──► delays ──► out
///                             ▲
///     torque ──► command_delay ──► drive_errors ──► drive_lag
///
///     ports in   torque           of the joints [N m]
///                pull             one more force on the robot; none if not connected
///     ports out  state            the true one
///                ground_forces    on the feet, the true ones
///                external_torque  of forces on the legs at the joints, the true one [N m]
///                joints           of the encoders
///                measured_torque  of the joints [N m]
///                foot_forces      as measured, by `foot_sensing` in W or in the shanks' axes
///                inertial         of the trunk's inertial unit
///
/// The blocks are public, for logs and for taking it apart.
class QuadrupedWorld final : public Subdiagram {
 public:
  explicit QuadrupedWorld(const QuadrupedWorldParams& params);

  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<ExternalForce> pull{this, {"pull"}, ExternalForce{}};

  QuadrupedPlant& plant;
  JointEncoders& encoders;
  JointTorqueSensor& torque_sensor;
  FootForceSensor& foot_sensor;
  TrunkImu& imu;
  ForceBundle& disturbances;
  SlidingLoad* sliding_load = nullptr;  ///< if there is one

  OutputPort<LeggedState> state{this, {"state"}};
  OutputPort<FootForces> ground_forces{this, {"ground_forces"}};
  OutputPort<Vec<12>> external_torque{this, {"external_torque", "N m", kJointElements}};
  OutputPort<JointMotion> joints{this, {"joints"}};
  OutputPort<Vec<12>> measured_torque{this, {"measured_torque", "N m", kJointElements}};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};

 private:
  void ConnectDrives(const QuadrupedHardwareParams& hardware);
};

}  // namespace tenon
