#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/plants/robots/robot_links.h>

namespace tenon::apps {

/// The sensors of a quadruped in an MCAP file. Times are relative to the first sample of the last topic that
/// begins [s].
struct SensorLog {
  Recording<JointMotion> joints;
  Recording<Vec<12>> torque;    ///< measured [N m]
  Recording<Vec<12>> commands;  ///< /joint_commands [N m]; may be empty
  Recording<ImuMeasurement> imu;
  std::array<Recording<Vec<3>>, kNumLegs> feet;  ///< ground forces in the axes of the trunk [N]
  Recording<LeggedState> odometry;               ///< /odom, pose and velocity; may be empty
  Recording<LeggedState> truth;                  ///< /ground_truth, as odometry
  double start = 0;                              ///< stamp of the time 0 [s]
  double end = 0;                                ///< last time at which all topics have samples [s]
  Rate rate = Hz(1000);                          ///< of joints or IMU, whichever is slower
  long gaps = 0;                                 ///< intervals of more than 2.5 periods of a topic
  double longest_gap = 0;                        ///< [s]
  std::vector<std::string> told;                 ///< damage, refused messages and gaps
};

/// Reads JointState and Imu, and WrenchStamped of the feet if there are foot sensors, with the topics and
/// frames of QuadrupedMessages; the frame of the IMU may be any link at rest in the trunk. Times are the
/// stamps, or without stamps the times of recording. Throws ParameterError for a file without whole
/// messages of a topic, and for another robot.
SensorLog ReadSensorLog(const std::filesystem::path& file, const QuadrupedDescription& robot,
                        const RobotLinks& links, bool foot_sensors);

/// State estimator and disturbance observers on the sensors of a log. A foot stands from when its vertical
/// force exceeds ContactThresholds::touch until it is below `leave`.
///
///     log ──► joints, imu ────────────► estimator ──► observer ──► wrench, forces on the legs
///      └────► foot forces or torques ──► schedule ──────┘
struct LogEstimator {
  LeggedStateEstimator& estimator;
  DisturbanceObserver& observer;
  const OutputPort<Vec<12>>& torque;          ///< as measured [N m]
  const OutputPort<FootForces>& foot_forces;  ///< in W
  const OutputPort<ContactSchedule>& schedule;
  const OutputPort<Geometry>& geometry;
};

/// The log of the option --estimate or --identify, and the parameters of its LogEstimator.
struct LoadedLog {
  QuadrupedScenario scenario;  ///< without plots and signals of a simulation
  QuadrupedWalkParams walk;
  SensorLog log;
};
/// Throws ParameterError for a scenario that stands, and as ReadSensorLog does.
LoadedLog LoadLog(const std::filesystem::path& file, const QuadrupedScenario& scenario);

/// Adds the blocks. Throws ParameterError.
LogEstimator AddLogEstimator(DiagramBuilder& builder, const LoadedLog& loaded);

/// The option --estimate: the scenario's estimator and observers on an MCAP file; a log with /odom or
/// /ground_truth is compared with it. With `identify`, the option --identify, see Identification. Throws as
/// LoadLog does.
RunResult RunEstimate(const std::filesystem::path& file, const QuadrupedScenario& scenario,
                      const RunOptions& options, bool identify = false);

/// The option --identify: drives and load of the robot in a log, by bounded least squares.
///
/// **Legs in swing**, whose feet bear no force. With the momentum p of a joint in a model without rotors
/// (QuadrupedDynamics::leg_momentum), its known rate r, the measured torque tau, and test functions phi that
/// vanish with their slope at the ends of an interval, integration by parts needs no accelerations:
///
///     integral of phi tau = s integral of (-phi' p - phi r) + I integral of -phi' qd
///                           + d integral of phi qd + c integral of phi tanh(qd / 0.1)
///
/// for the factor s of the legs' masses, rotor inertia I, viscous friction d and Coulomb friction c. Speeds
/// are central differences of the angles.
///
/// **Drives.** The measured torque of joint j is g_j times the command after a delay and a lag of first
/// order, except near the limits of the drive. The delay has the jitter of the scenario's hardware.
///
/// **Load.** Means of the observer's wrench are those of a mass on the trunk at (x, y), by the specific force
/// of the IMU. Its height is that of the scenario's payload.
///
/// The deviations are those of Gauss and Newton, (J^T J)^-1 J^T C J (J^T J)^-1 with the Jacobian J of the
/// residuals and their covariance C, estimated in blocks, so that residuals may be correlated within a block.
class Identification {
 public:
  /// Collects samples in a run of the simulator. `command` is null if the log has no commands. The arguments
  /// must outlive this object.
  Identification(const LoadedLog& loaded, const LogEstimator& blocks, const OutputPort<Vec<12>>* command,
                 Simulator& simulator);

  /// Sets the figures, and writes hardware.yaml and identified.yaml, a scenario with it and with the load,
  /// into a directory. Parameters that the log does not determine keep their values in the scenario and are
  /// noted.
  void AddTo(Summary& summary, const std::filesystem::path& directory, const QuadrupedScenario& given) const;

  struct Sample;

 private:
  class Samples;
  const LoadedLog& loaded_;
  bool commanded_;
  std::shared_ptr<Samples> samples_;
};

}  // namespace tenon::apps
