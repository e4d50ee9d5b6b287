#pragma once

#include <tenon/apps/quadruped/log_estimator.h>

namespace tenon::apps {

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
