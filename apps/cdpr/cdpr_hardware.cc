#include <tenon/apps/cdpr/cdpr_hardware.h>
#include <tenon/systems/yaml/resources.h>

namespace tenon::apps {

FieldList CdprSensors::Fields() {
  using S = CdprSensors;
  return {{"cables", &S::cables}, {"pose", &S::pose}, {"imu", &S::imu}};
}

FieldList CdprHardware::Fields() {
  using S = CdprHardware;
  return {{"description", &S::description},
          {"winches", &S::winches},
          {"link", &S::link},
          {"calculation", &S::calculation},
          {"sensors", &S::sensors}};
}

void SetHardware(const YamlFile& what, CdprLoopParams& loop) {
  CdprHardware hardware = LoadResource("hardware/cdpr", what).Read<CdprHardware>();
  auto& [cables, pose, imu] = hardware.sensors;
  CdprHardwareParams& params = loop.hardware;
  hardware.winches.num_cables = loop.robot.num_cables();
  hardware.winches.rate = hardware.link.rate = loop.mpc ? loop.mpc->command_rate : loop.control_rate;
  hardware.link.initial = CableVector::Zero(loop.robot.num_cables());
  if (hardware.calculation.any() && !loop.mpc)
    throw ParameterError(
        "calculation has no effect without predictive control: choose a controller with an MPC, or remove "
        "it");
  params.calculation = hardware.calculation;
  if (hardware.winches.any()) params.winch_errors = hardware.winches;
  hardware.link.Validate();
  if (hardware.link.delay > 0) params.command_delay = hardware.link;
  params.cable_sensors = cables;
  if (cables) params.cable_sensors->num_cables = loop.robot.num_cables();
  loop.pose_sensor.position_offset = pose.position_offset;
  loop.pose_sensor.attitude_offset = pose.attitude_offset;
  params.pose_delay = pose.latency;
  imu.rate = loop.imu.rate;
  if (imu.any()) params.imu_errors = imu;
  params.imu_delay = imu.latency;
}

}  // namespace tenon::apps
