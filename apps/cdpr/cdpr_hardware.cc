#include <tenon/apps/cdpr/cdpr_hardware.h>
#include <tenon/apps/common/ranges.h>
#include <tenon/systems/yaml/resources.h>

namespace tenon::apps {

FieldList WinchScenario::Fields() {
  using S = WinchScenario;
  return {Field("gain_deviation", &S::gain_deviation).Between(0, 0.5),
          Field("ripple_ratio", &S::ripple_ratio).Between(0, 0.5),
          Field("friction_ratio", &S::friction_ratio).Between(0, 0.5),
          Field("friction_speed_m_per_s", &S::friction_speed_m_per_s).Positive()};
}

FieldList CableSensorScenario::Fields() {
  using S = CableSensorScenario;
  return {Field("rate_hz", &S::rate_hz).In(Rates()),
          Field("latency_samples", &S::latency_samples).In(Latencies()),
          Field("resolution_m", &S::resolution_m).AtLeast(0),
          Field("offset_m", &S::offset_m).AtLeast(0),
          Field("rate_bandwidth_hz", &S::rate_bandwidth_hz).AtLeast(0),
          Field("tension_noise_ratio", &S::tension_noise_ratio).AtLeast(0),
          Field("tension_offset_N", &S::tension_offset_N).AtLeast(0)};
}

FieldList PoseHardwareScenario::Fields() {
  using S = PoseHardwareScenario;
  return {Field("latency_samples", &S::latency_samples).In(Latencies()),
          Field("offset_m", &S::offset_m).AtLeast(0), Field("offset_rad", &S::offset_rad).AtLeast(0)};
}

FieldList ImuHardwareScenario::Fields() {
  using S = ImuHardwareScenario;
  return {
      Field("latency_samples", &S::latency_samples).In(Latencies()),
      Field("angular_velocity_bias_deviation_rad_per_s", &S::angular_velocity_bias_deviation_rad_per_s)
          .AtLeast(0),
      Field("acceleration_bias_deviation_m_per_s2", &S::acceleration_bias_deviation_m_per_s2).AtLeast(0),
      Field("angular_velocity_walk_rad_per_s_per_sqrt_s", &S::angular_velocity_walk_rad_per_s_per_sqrt_s)
          .AtLeast(0),
      Field("acceleration_walk_m_per_s2_per_sqrt_s", &S::acceleration_walk_m_per_s2_per_sqrt_s).AtLeast(0),
      Field("misalignment_rad", &S::misalignment_rad).AtLeast(0)};
}

FieldList CdprSensorsScenario::Fields() {
  using S = CdprSensorsScenario;
  return {{"cables", &S::cables}, {"pose", &S::pose}, {"imu", &S::imu}};
}

FieldList CdprHardwareScenario::Fields() {
  using S = CdprHardwareScenario;
  return {{"description", &S::description},
          {"winches", &S::winches},
          {"link", &S::link},
          {"sensors", &S::sensors}};
}

CdprHardwareScenario LoadCdprHardware(const YamlFile& what) {
  return LoadResource("hardware/cdpr", what).Read<CdprHardwareScenario>();
}

void SetHardware(const CdprHardwareScenario& hardware, CdprLoopParams& loop) {
  const auto& [cables, pose, imu] = hardware.sensors;
  const WinchScenario& winches = hardware.winches;
  CdprHardwareParams& params = loop.hardware;
  const int num_cables = loop.robot.num_cables();
  const Rate rate = loop.mpc ? loop.mpc->command_rate : loop.control_rate;
  if (winches.gain_deviation > 0 || winches.ripple_ratio > 0 || winches.friction_ratio > 0)
    params.winch_errors = {.num_cables = num_cables,
                           .rate = rate,
                           .gain_deviation = winches.gain_deviation,
                           .ripple = winches.ripple_ratio,
                           .friction = winches.friction_ratio,
                           .friction_speed = winches.friction_speed_m_per_s};
  if (hardware.link.delay_s > 0)
    params.command_delay = {.delay = hardware.link.delay_s,
                            .jitter = hardware.link.jitter_s,
                            .initial = CableVector::Zero(num_cables),
                            .rate = rate,
                            .unit = "N"};
  const bool measured = cables.rate_hz || cables.resolution_m > 0 || cables.offset_m > 0 ||
                        cables.rate_bandwidth_hz > 0 || cables.tension_noise_ratio > 0 ||
                        cables.tension_offset_N > 0;
  if (measured || cables.latency_samples > 0)
    params.cable_sensors = {.num_cables = num_cables,
                            .rate = Hz(cables.rate_hz.value_or(1000)),
                            .resolution = cables.resolution_m,
                            .length_offset = cables.offset_m,
                            .rate_bandwidth = cables.rate_bandwidth_hz,
                            .tension_noise = cables.tension_noise_ratio,
                            .tension_offset = cables.tension_offset_N};
  params.cable_delay = cables.latency_samples;
  loop.pose_sensor.position_offset = pose.offset_m;
  loop.pose_sensor.attitude_offset = pose.offset_rad;
  params.pose_delay = pose.latency_samples;
  const ImuErrorsParams errors{.rate = loop.imu.rate,
                               .misalignment = imu.misalignment_rad,
                               .angular_velocity_bias = imu.angular_velocity_bias_deviation_rad_per_s,
                               .specific_force_bias = imu.acceleration_bias_deviation_m_per_s2,
                               .angular_velocity_walk = imu.angular_velocity_walk_rad_per_s_per_sqrt_s,
                               .specific_force_walk = imu.acceleration_walk_m_per_s2_per_sqrt_s};
  if (errors.misalignment > 0 || errors.angular_velocity_bias > 0 || errors.specific_force_bias > 0 ||
      errors.angular_velocity_walk > 0 || errors.specific_force_walk > 0)
    params.imu_errors = errors;
  params.imu_delay = imu.latency_samples;
}

}  // namespace tenon::apps
