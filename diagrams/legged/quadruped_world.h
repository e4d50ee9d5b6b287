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

namespace tenon {

/// Sensors of the forces on the feet.
enum class FootSensing {
  kWorld,  ///< ideal axes: forces are measured in W
  kShank,  ///< sensors in the shanks: forces are measured in the axes of the shanks
  kNone,   ///< no sensors: nothing reads `foot_forces`
};

/// Sensors of the ground forces on the feet.
struct FootForceSensors : Delayed<FootForceSensorParams> {
  /// Axes of the sensors. Forces in the axes of the shanks are rotated by the estimated state. Without
  /// sensors the forces are estimated from the joint torques.
  FootSensing mounted = FootSensing::kWorld;

  static FieldList Fields() { return Delayed::Fields() + FieldList{{"mounted", &FootForceSensors::mounted}}; }
};

/// Inertial unit on the trunk, which measures angular velocity and specific force; by default without errors.
struct TrunkImuParams : Delayed<ImuParams> {
  TrunkImuParams() { angular_velocity_noise = specific_force_noise = Vec<3>::Zero(); }
  ImuErrorsParams unit;  ///< errors of the individual unit, at the rate of the samples

  static FieldList Fields() {
    FieldList fields = Delayed::Fields();
    AddInline(fields, &TrunkImuParams::unit);
    return fields;
  }
};

/// Sensors of a quadruped. Noise is white and given by its standard deviation. Each sensor has a random
/// stream of its own, which depends on the run's seed and the sensor's name.
struct QuadrupedSensors {
  Delayed<JointEncodersParams> encoders;      ///< encoders of the joints
  Delayed<TorqueSensorParams> torque_sensor;  ///< torque sensors of the joints
  FootForceSensors foot_sensor;
  TrunkImuParams imu;  ///< inertial unit on the trunk; p_B is taken from the robot

  static FieldList Fields() {
    using S = QuadrupedSensors;
    return {{"encoders", &S::encoders},
            {"torque", &S::torque_sensor},
            {"foot_force", &S::foot_sensor},
            {"imu", &S::imu}};
  }
};

/// Delays and errors between a controller and the ideal drives. Empty members are left out.
struct QuadrupedHardwareParams {
  std::optional<JitteredDelayParams<Vec<12>>> command_delay;  ///< computation and field bus
  std::optional<DriveErrorsParams> drive_errors;
  std::optional<HeldLagParams<Vec<12>>> drive_lag;
};

/// Height of the trunk below which a robot has fallen, relative to that in its nominal stance.
inline constexpr double kFallHeightRatio = 0.5;

struct QuadrupedWorldParams : QuadrupedSensors {
  QuadrupedPlantParams plant;
  QuadrupedHardwareParams hardware;
  std::optional<SlidingLoadParams> sliding_load;  ///< initial state and gravity are taken from the plant
  // All forces together, with `pull`, must not exceed kMaxExternalForces.
  std::vector<PulseForceParams> pulses;
  std::vector<SineForceParams> sines;
  std::vector<RandomForceParams> random;
  double min_height =
      0;                ///< least height of the trunk above the ground, below which the robot has fallen [m]
  double max_tilt = 1;  ///< largest tilt of the trunk, above which the robot has fallen [rad]
  double max_height = 10;  ///< largest height of the trunk above the ground [m]
};

/// Parameters of a robot at rest in its nominal stance on the ground at the origin of W, without
/// disturbances. Throws ParameterError if the robot cannot stand there, see StandingOn.
QuadrupedWorldParams MakeQuadrupedWorld(const QuadrupedDescription& robot, const TerrainParams& terrain = {});

/// Everything that a quadruped's controller is connected to: the robot on its terrain, its sensors, the
/// forces that disturb it, and a monitor that ends the run when the robot falls.
///
///     pull, disturbances ──► plant ──► encoders, torque_sensor, foot_sensor, imu ──► delays ──► out
///                             ▲
///     torque ──► command_delay ──► drive_errors ──► drive_lag
///
/// The first four outputs are true and the others measured; `foot_forces` are in W or in the axes of the
/// shanks, see FootSensing. `external_torque` is that of disturbing forces on the legs.
///
/// The blocks are public members, so that a program can log or replace them.
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
  FallMonitor& monitor;
  SlidingLoad* sliding_load = nullptr;  ///< null without a sliding load

  OutputPort<LeggedState> state{this, {"state"}};
  OutputPort<FootForces> ground_forces{this, {"ground_forces"}};
  OutputPort<Vec<12>> external_torque{this, {"external_torque", "N m", kJointElements}};
  OutputPort<WrenchEstimate> added_wrench{this, {"added_wrench"}};
  OutputPort<JointMotion> joints{this, {"joints"}};
  OutputPort<Vec<12>> measured_torque{this, {"measured_torque", "N m", kJointElements}};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};

 private:
  void ConnectDrives(const QuadrupedHardwareParams& hardware);
};

}  // namespace tenon
