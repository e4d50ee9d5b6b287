#pragma once

#include <tenon/diagrams/cdpr/cdpr_loop_params.h>
#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

/// Everything of a cable robot's run that is not the controller's: the robot, its drives and sensors, the
/// loads and gusts that disturb it, and a monitor that ends the run.
///
///     payload, gusts, hanging_load ──► plant ──► pose_sensor, imu, cable_sensors ──► delays ──► out
///                                       ▲
///     command ──► command_delay ──► winch_errors
///
/// The constructor adds the blocks to `loop` itself, so that their names are those of the loop.
struct CdprWorld {
  /// @throws ParameterError if a cable has no length at the start of the path.
  CdprWorld(Subdiagram& loop, const CdprLoopParams& params);

  PayloadSchedule& payload;
  CdprPlant& plant;
  PoseSensor& pose_sensor;
  Imu& imu;
  CdprMonitor& monitor;
  Gusts* gusts = nullptr;               ///< null without gusts
  HangingLoad* hanging_load = nullptr;  ///< null without a hanging load

  InputPort<CableVector>& command;             ///< input to connect with the controller's command [N]
  const OutputPort<CableSignals>& cables;      ///< measured cable signals, with their latency
  const OutputPort<PoseMeasurement>& pose;     ///< measured pose, with its latency
  const OutputPort<ImuMeasurement>& inertial;  ///< measurement of the IMU, with its latency

 private:
  void AddDisturbances(Subdiagram& loop, const CdprLoopParams& params);
};

}  // namespace tenon
