#include <tenon/diagrams/cdpr/cdpr_world.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/primitives/late.h>

namespace tenon {
namespace {

CdprPlantParams AtRest(const CdprLoopParams& loop) {
  const CdprReference start = loop.path->At(0);
  CdprPlantParams params;
  params.robot = loop.robot;
  params.extend = loop.extend;
  if (loop.robot.on_table) params.gravity = 0;
  params.p_WB = start.position + loop.start_offset;
  params.euler = start.euler + loop.start_turn;
  params.initial_tension = start.tension;
  try {
    params.homed_length =
        CalcCableKinematics(loop.path->robot(), params.p_WB, RotationFromEuler(params.euler)).length;
  } catch (const RunError& error) {
    throw ParameterError(std::string("at the start: ") + error.what());
  }
  return params;
}

CableSignals CablesAtRest(const CdprPlantParams& start) {
  const CableVector& length = start.homed_length;
  return {length, CableVector::Zero(length.size()), start.initial_tension,
          CalcRestLengths(start.robot.cable, length, start.initial_tension)};
}

/// Adds the blocks between the controller and the plant; returns the input of the first one.
InputPort<CableVector>& AddDrives(Subdiagram& loop, const CdprHardwareParams& hardware, CdprPlant& plant) {
  InputPort<CableVector>* in = &plant.command;
  if (hardware.winch_errors) {
    auto& errors = loop.Add<WinchErrors>("winch_errors", *hardware.winch_errors);
    loop.Connect(plant.cables, errors.cables);
    loop.Connect(errors.tension, *in);
    in = &errors.command;
  }
  if (hardware.command_delay) {
    JitteredDelayParams<CableVector> delay_params = *hardware.command_delay;
    delay_params.initial = plant.params.initial_tension;
    auto& delay = loop.Add<JitteredDelay<CableVector>>("command_delay", delay_params);
    loop.Connect(delay.y, *in);
    in = &delay.u;
  }
  return *in;
}

const OutputPort<CableSignals>& AddCableSensors(Subdiagram& loop, const CdprHardwareParams& hardware,
                                                CdprPlant& plant) {
  if (!hardware.cable_sensors) return plant.cables;
  auto& sensors = loop.Add<CableSensors>("cable_sensors", *hardware.cable_sensors);
  loop.Connect(plant.cables, sensors.cables);
  return Late(loop, "cables", sensors.measured, CablesAtRest(plant.params), hardware.cable_sensors->rate,
              hardware.cable_sensors->latency);
}

const OutputPort<PoseMeasurement>& AddPoseDelay(Subdiagram& loop, const CdprHardwareParams& hardware,
                                                const CdprPlantParams& start, PoseSensor& sensor) {
  const Eigen::Matrix3d R_WB = RotationFromEuler(start.euler);
  return Late<PoseMeasurement>(loop, "pose", sensor.pose, {start.p_WB, QuaternionFromRotation(R_WB)},
                               sensor.params.rate, hardware.pose_delay);
}

const OutputPort<ImuMeasurement>& AddImuErrors(Subdiagram& loop, const CdprHardwareParams& hardware,
                                               const CdprPlantParams& start, Imu& imu) {
  const OutputPort<ImuMeasurement>* measured = &imu.measurement;
  if (hardware.imu_errors) {
    auto& errors = loop.Add<ImuErrors>("imu_errors", *hardware.imu_errors);
    loop.Connect(*measured, errors.measurement);
    measured = &errors.measured;
  }
  const Eigen::Matrix3d R_WB = RotationFromEuler(start.euler);
  return Late<ImuMeasurement>(loop, "inertial", *measured,
                              {Vec<3>::Zero(), R_WB.transpose() * Vec<3>(0, 0, imu.params.gravity)},
                              imu.params.rate, hardware.imu_delay);
}

}  // namespace

CdprWorld::CdprWorld(Subdiagram& loop, const CdprLoopParams& params)
    : payload(loop.Add<PayloadSchedule>("payload", params.payload)),
      plant(loop.Add<CdprPlant>("plant", AtRest(params))),
      pose_sensor(loop.Add<PoseSensor>("pose_sensor", params.pose_sensor)),
      imu(loop.Add<Imu>("imu", params.imu)),
      monitor(
          loop.Add<CdprMonitor>("monitor", CdprMonitorParams{.robot = params.robot,
                                                             .forbid_slack = params.forbid_slack,
                                                             .max_tension_ratio = params.max_tension_ratio,
                                                             .rate = params.control_rate})),
      command(AddDrives(loop, params.hardware, plant)),
      cables(AddCableSensors(loop, params.hardware, plant)),
      pose(AddPoseDelay(loop, params.hardware, plant.params, pose_sensor)),
      inertial(AddImuErrors(loop, params.hardware, plant.params, imu)) {
  AddDisturbances(loop, params);
  loop.Connect(payload.payload, plant.payload);
  loop.Connect(plant.cables, monitor.cables);
  loop.Connect(plant.platform, monitor.platform);
  loop.Connect(plant.platform, pose_sensor.platform);
  loop.Connect(plant.platform, imu.body);
  loop.Connect(plant.acceleration, imu.acceleration);
}

void CdprWorld::AddDisturbances(Subdiagram& loop, const CdprLoopParams& params) {
  const OutputPort<PlatformWrench>* wrench = nullptr;
  if (!params.gusts.gusts.empty()) {
    gusts = &loop.Add<Gusts>("gusts", params.gusts);
    wrench = &gusts->wrench;
  }
  if (params.hanging_load) {
    const CdprPlantParams& start = plant.params;
    HangingLoadParams load_params = *params.hanging_load;
    const double length =
        load_params.length * (1 + load_params.mass * load_params.gravity / load_params.axial_stiffness);
    const double depth = std::sqrt(std::max(0.0, length * length - params.swing.squaredNorm()));
    load_params.p_W = start.p_WB + RotationFromEuler(start.euler) * load_params.attachment_B + params.swing -
                      Vec<3>(0, 0, depth);
    hanging_load = &loop.Add<HangingLoad>("hanging_load", load_params);
    loop.Connect(plant.platform, hanging_load->platform);
    if (wrench != nullptr) loop.Connect(*wrench, hanging_load->others);
    wrench = &hanging_load->wrench;
  }
  if (wrench != nullptr) loop.Connect(*wrench, plant.wrench);
}

}  // namespace tenon
