#include <tenon/apps/common/ranges.h>
#include <tenon/apps/quadruped/quadruped_hardware.h>
#include <tenon/systems/yaml/resources.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tenon::apps {

FieldList EncoderScenario::Fields() {
  using S = EncoderScenario;
  return {Field("rate_hz", &S::rate_hz).In(Rates()),
          Field("latency_samples", &S::latency_samples).In(Latencies()),
          Field("angle_noise_rad", &S::angle_noise_rad).AtLeast(0),
          {"angle_bias_rad", &S::angle_bias_rad},
          Field("speed_noise_rad_per_s", &S::speed_noise_rad_per_s).AtLeast(0),
          {"speed_bias_rad_per_s", &S::speed_bias_rad_per_s},
          Field("bits", &S::bits).Between(1, 52),
          Field("offset_rad", &S::offset_rad).AtLeast(0),
          Field("speed_bandwidth_hz", &S::speed_bandwidth_hz).AtLeast(0)};
}

FieldList TorqueSensorScenario::Fields() {
  using S = TorqueSensorScenario;
  return {Field("rate_hz", &S::rate_hz).In(Rates()),
          Field("latency_samples", &S::latency_samples).In(Latencies()),
          Field("noise_ratio", &S::noise_ratio).AtLeast(0),
          {"bias_N_m", &S::bias_N_m}};
}

FieldList FootForceSensorScenario::Fields() {
  using S = FootForceSensorScenario;
  return {Field("rate_hz", &S::rate_hz).In(Rates()),
          Field("latency_samples", &S::latency_samples).In(Latencies()),
          Field("noise_ratio", &S::noise_ratio).AtLeast(0),
          Field("noise_weight_ratio", &S::noise_weight_ratio).AtLeast(0),
          {"bias_N", &S::bias_N},
          Field("threshold_weight_ratio", &S::threshold_weight_ratio).AtLeast(0),
          {"mounted", &S::mounted}};
}

FieldList ImuScenario::Fields() {
  using S = ImuScenario;
  return {
      Field("rate_hz", &S::rate_hz).In(Rates()),
      Field("latency_samples", &S::latency_samples).In(Latencies()),
      Field("angular_velocity_noise_rad_per_s", &S::angular_velocity_noise_rad_per_s).AtLeast(0),
      {"angular_velocity_bias_rad_per_s", &S::angular_velocity_bias_rad_per_s},
      Field("acceleration_noise_m_per_s2", &S::acceleration_noise_m_per_s2).AtLeast(0),
      {"acceleration_bias_m_per_s2", &S::acceleration_bias_m_per_s2},
      Field("angular_velocity_bias_deviation_rad_per_s", &S::angular_velocity_bias_deviation_rad_per_s)
          .AtLeast(0),
      Field("acceleration_bias_deviation_m_per_s2", &S::acceleration_bias_deviation_m_per_s2).AtLeast(0),
      Field("angular_velocity_walk_rad_per_s_per_sqrt_s", &S::angular_velocity_walk_rad_per_s_per_sqrt_s)
          .AtLeast(0),
      Field("acceleration_walk_m_per_s2_per_sqrt_s", &S::acceleration_walk_m_per_s2_per_sqrt_s).AtLeast(0),
      Field("misalignment_rad", &S::misalignment_rad).AtLeast(0)};
}

FieldList SensorScenario::Fields() {
  using S = SensorScenario;
  return {
      {"encoders", &S::encoders}, {"torque", &S::torque}, {"foot_force", &S::foot_force}, {"imu", &S::imu}};
}

FieldList DriveScenario::Fields() {
  using S = DriveScenario;
  return {Field("rotor_acceleration_rad_per_s2", &S::rotor_acceleration_rad_per_s2).Positive(),
          Field("friction_ratio", &S::friction_ratio).Between(0, 1),
          Field("damping_ratio", &S::damping_ratio).Between(0, 1),
          Field("gain_deviation", &S::gain_deviation).Between(0, 0.5),
          Field("ripple_ratio", &S::ripple_ratio).Between(0, 0.5),
          Field("bandwidth_hz", &S::bandwidth_hz).Between(0.1, 1e6),
          {"limit_speed", &S::limit_speed}};
}

FieldList HardwareScenario::Fields() {
  using S = HardwareScenario;
  return {
      {"description", &S::description}, {"drives", &S::drives}, {"link", &S::link}, {"sensors", &S::sensors}};
}

namespace {

/// Returns `first`, in which empty optionals of `members` are replaced by those of `then`.
template <class S, class... Members>
S Over(const S& first, const S& then, Members... members) {
  S both = first;
  const auto fill = [&](auto member) {
    if (!(both.*member)) both.*member = then.*member;
  };
  (fill(members), ...);
  return both;
}

EncoderScenario Over(const EncoderScenario& first, const EncoderScenario& then) {
  using S = EncoderScenario;
  return Over(first, then, &S::rate_hz, &S::latency_samples, &S::angle_noise_rad, &S::angle_bias_rad,
              &S::speed_noise_rad_per_s, &S::speed_bias_rad_per_s, &S::bits, &S::offset_rad,
              &S::speed_bandwidth_hz);
}

TorqueSensorScenario Over(const TorqueSensorScenario& first, const TorqueSensorScenario& then) {
  using S = TorqueSensorScenario;
  return Over(first, then, &S::rate_hz, &S::latency_samples, &S::noise_ratio, &S::bias_N_m);
}

FootForceSensorScenario Over(const FootForceSensorScenario& first, const FootForceSensorScenario& then) {
  using S = FootForceSensorScenario;
  return Over(first, then, &S::rate_hz, &S::latency_samples, &S::noise_ratio, &S::noise_weight_ratio,
              &S::bias_N, &S::threshold_weight_ratio, &S::mounted);
}

ImuScenario Over(const ImuScenario& first, const ImuScenario& then) {
  using S = ImuScenario;
  return Over(first, then, &S::rate_hz, &S::latency_samples, &S::angular_velocity_noise_rad_per_s,
              &S::angular_velocity_bias_rad_per_s, &S::acceleration_noise_m_per_s2,
              &S::acceleration_bias_m_per_s2, &S::angular_velocity_bias_deviation_rad_per_s,
              &S::acceleration_bias_deviation_m_per_s2, &S::angular_velocity_walk_rad_per_s_per_sqrt_s,
              &S::acceleration_walk_m_per_s2_per_sqrt_s, &S::misalignment_rad);
}

/// Smallest difference of two angles that the encoders resolve; 0 for ideal encoders [rad].
double ResolutionOf(const EncoderScenario& encoders) {
  return encoders.bits ? std::ldexp(2 * std::numbers::pi, -*encoders.bits) : 0;
}

/// Sets a value if the scenario gives it; otherwise the library's default remains.
template <class Value>
void Take(const std::optional<Value>& given, auto& value) {
  if (given) value = *given;
}

void TakeRate(const std::optional<double>& hz, Rate& rate) {
  if (hz) rate = Hz(*hz);
}

double WeightOf(const QuadrupedWorldParams& world) {
  return world.plant.robot.mass() * world.plant.gravity;
}

void SetSensors(const SensorScenario& sensors, QuadrupedWorldParams& world) {
  const auto& [encoders, torque, foot_force, imu] = sensors;
  QuadrupedHardwareParams& hardware = world.hardware;

  JointEncodersParams& angles = world.encoders;
  TakeRate(encoders.rate_hz, angles.rate);
  Take(encoders.angle_noise_rad, angles.angle.absolute);
  Take(encoders.angle_bias_rad, angles.angle.bias);
  Take(encoders.speed_noise_rad_per_s, angles.speed.absolute);
  Take(encoders.speed_bias_rad_per_s, angles.speed.bias);
  angles.resolution = ResolutionOf(encoders);
  Take(encoders.offset_rad, angles.offset_deviation);
  Take(encoders.speed_bandwidth_hz, angles.speed_bandwidth);
  Take(encoders.latency_samples, hardware.encoder_delay);

  TakeRate(torque.rate_hz, world.torque_sensor.rate);
  Take(torque.noise_ratio, world.torque_sensor.error.relative);
  Take(torque.bias_N_m, world.torque_sensor.error.bias);
  Take(torque.latency_samples, hardware.torque_delay);

  const double weight = WeightOf(world);
  FootForceSensorParams& feet = world.foot_sensor;
  TakeRate(foot_force.rate_hz, feet.rate);
  if (foot_force.noise_weight_ratio) feet.error.absolute = weight * *foot_force.noise_weight_ratio;
  Take(foot_force.noise_ratio, feet.error.relative);
  Take(foot_force.bias_N, feet.error.bias);
  if (foot_force.threshold_weight_ratio) feet.threshold = weight * *foot_force.threshold_weight_ratio;
  Take(foot_force.latency_samples, hardware.foot_delay);
  Take(foot_force.mounted, hardware.foot_sensing);

  TakeRate(imu.rate_hz, world.imu.rate);
  if (imu.angular_velocity_noise_rad_per_s)
    world.imu.angular_velocity_noise.setConstant(*imu.angular_velocity_noise_rad_per_s);
  Take(imu.angular_velocity_bias_rad_per_s, world.imu.angular_velocity_bias);
  if (imu.acceleration_noise_m_per_s2)
    world.imu.specific_force_noise.setConstant(*imu.acceleration_noise_m_per_s2);
  Take(imu.acceleration_bias_m_per_s2, world.imu.specific_force_bias);
  if (imu.misalignment_rad || imu.angular_velocity_bias_deviation_rad_per_s ||
      imu.acceleration_bias_deviation_m_per_s2 || imu.angular_velocity_walk_rad_per_s_per_sqrt_s ||
      imu.acceleration_walk_m_per_s2_per_sqrt_s)
    hardware.imu_errors = {
        .rate = world.imu.rate,
        .misalignment = imu.misalignment_rad.value_or(0),
        .angular_velocity_bias = imu.angular_velocity_bias_deviation_rad_per_s.value_or(0),
        .specific_force_bias = imu.acceleration_bias_deviation_m_per_s2.value_or(0),
        .angular_velocity_walk = imu.angular_velocity_walk_rad_per_s_per_sqrt_s.value_or(0),
        .specific_force_walk = imu.acceleration_walk_m_per_s2_per_sqrt_s.value_or(0)};
  Take(imu.latency_samples, hardware.imu_delay);
}

/// All drives are equal. Ratios are relative to the mean of the joints' limits.
void SetDrives(const DriveScenario& drives, Rate rate, QuadrupedWorldParams& world) {
  double torque = 0, speed = 0;
  for (int j = 0; j < kNumJoints; ++j) {
    torque += world.plant.robot.joint(j).torque_limit / kNumJoints;
    speed += world.plant.robot.joint(j).speed_limit / kNumJoints;
  }
  DriveProperties& properties = world.plant.robot.drive;
  if (drives.rotor_acceleration_rad_per_s2)
    properties.rotor_inertia = torque / *drives.rotor_acceleration_rad_per_s2;
  if (drives.friction_ratio) properties.friction = torque * *drives.friction_ratio;
  if (drives.damping_ratio) properties.damping = torque * *drives.damping_ratio / speed;
  if (drives.limit_speed) world.plant.limit_speed = true;
  if (drives.gain_deviation > 0 || drives.ripple_ratio > 0)
    world.hardware.drive_errors = {
        .rate = rate, .gain_deviation = drives.gain_deviation, .ripple = drives.ripple_ratio};
  if (drives.bandwidth_hz)
    world.hardware.drive_lag = {
        .time_constant = LagOfBandwidth(*drives.bandwidth_hz), .rate = rate, .unit = "N m"};
}

}  // namespace

HardwareScenario LoadHardware(const YamlFile& file) {
  return LoadResource("hardware/legged", file).Read<HardwareScenario>();
}

HardwareScenario WithSensors(HardwareScenario hardware, const SensorScenario& sensors) {
  SensorScenario& below = hardware.sensors;
  below = {.encoders = Over(sensors.encoders, below.encoders),
           .torque = Over(sensors.torque, below.torque),
           .foot_force = Over(sensors.foot_force, below.foot_force),
           .imu = Over(sensors.imu, below.imu)};
  return hardware;
}

void SetHardware(const HardwareScenario& hardware, Rate rate, QuadrupedWorldParams& world) {
  SetSensors(hardware.sensors, world);
  SetDrives(hardware.drives, rate, world);
  if (hardware.link.delay_s > 0)
    world.hardware.command_delay = {
        .delay = hardware.link.delay_s, .jitter = hardware.link.jitter_s, .rate = rate, .unit = "N m"};
}

ContactAidedNoise BelievedNoise(const HardwareScenario& hardware) {
  const auto& [encoders, torque, foot_force, imu] = hardware.sensors;
  ContactAidedNoise noise;
  noise.specific_force = std::max(imu.acceleration_noise_m_per_s2.value_or(0), 1e-3);
  noise.angular_velocity = std::max(imu.angular_velocity_noise_rad_per_s.value_or(0), 1e-4);
  noise.encoder = std::max(
      std::hypot(encoders.angle_noise_rad.value_or(0), ResolutionOf(encoders) / std::sqrt(12)), 1e-5);
  return noise;
}

}  // namespace tenon::apps
