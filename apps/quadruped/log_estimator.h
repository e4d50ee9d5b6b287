#pragma once

#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/apps/quadruped/sensor_log.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>

namespace tenon::apps {

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

}  // namespace tenon::apps
