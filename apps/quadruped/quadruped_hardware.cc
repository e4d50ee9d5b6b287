#include <tenon/apps/quadruped/quadruped_hardware.h>
#include <tenon/systems/yaml/resources.h>

namespace tenon::apps {

FieldList DriveRatings::Fields() {
  using S = DriveRatings;
  FieldList fields = DriveErrorsParams::Fields();
  fields.insert(fields.end(), {Field("rotor_acceleration_rad_per_s2", &S::rotor_acceleration).Positive(),
                               Field("friction_ratio", &S::friction_ratio).Between(0, 1),
                               Field("damping_ratio", &S::damping_ratio).Between(0, 1),
                               Field("bandwidth_hz", &S::bandwidth).Between(0.1, 1e6),
                               {"limit_speed", &S::limit_speed}});
  return fields;
}

FieldList QuadrupedHardware::Fields() {
  using S = QuadrupedHardware;
  return {{"description", &S::description},
          {"drives", &S::drives},
          {"link", &S::link},
          {"calculation", &S::calculation},
          {"sensors", &S::sensors}};
}

QuadrupedHardware LoadHardware(const YamlFile& file, const Scale& scale, const SensorChanges& sensors) {
  YamlDocument document = LoadResource("hardware/legged", file);
  document.Change("sensors", sensors);
  return document.Read<QuadrupedHardware>(&scale);
}

/// All drives are equal. Ratios are relative to the mean of the joints' limits.
static void SetDrives(const DriveRatings& drives, Rate rate, QuadrupedWorldParams& world) {
  double torque = 0, speed = 0;
  for (int j = 0; j < kNumJoints; ++j) {
    torque += world.plant.robot.joint(j).torque_limit / kNumJoints;
    speed += world.plant.robot.joint(j).speed_limit / kNumJoints;
  }
  DriveProperties& properties = world.plant.robot.drive;
  if (drives.rotor_acceleration) properties.rotor_inertia = torque / *drives.rotor_acceleration;
  if (drives.friction_ratio) properties.friction = torque * *drives.friction_ratio;
  if (drives.damping_ratio) properties.damping = torque * *drives.damping_ratio / speed;
  if (drives.limit_speed) world.plant.limit_speed = true;
  if (drives.gain_deviation > 0 || drives.ripple > 0) {
    world.hardware.drive_errors = drives;
    world.hardware.drive_errors->rate = rate;
  }
  if (drives.bandwidth)
    world.hardware.drive_lag = {
        .time_constant = LagOfBandwidth(*drives.bandwidth), .rate = rate, .unit = "N m"};
}

void SetHardware(const QuadrupedHardware& hardware, Rate rate, QuadrupedWorldParams& world,
                 SlowOptions* mpc) {
  if (hardware.calculation.any() && mpc == nullptr)
    throw ParameterError("calculation has no effect without predictive control: give walk.mpc, or remove it");
  if (mpc != nullptr) *mpc = hardware.calculation;
  static_cast<QuadrupedSensors&>(world) = hardware.sensors;
  SetDrives(hardware.drives, rate, world);
  if (hardware.link.delay > 0) {
    world.hardware.command_delay = hardware.link;
    world.hardware.command_delay->rate = rate;
    world.hardware.command_delay->Validate();
  }
}

ContactAidedNoise BelievedNoise(const QuadrupedSensors& sensors) {
  ContactAidedNoise noise;
  noise.specific_force = std::max(sensors.imu.specific_force_noise.maxCoeff(), 1e-3);
  noise.angular_velocity = std::max(sensors.imu.angular_velocity_noise.maxCoeff(), 1e-4);
  noise.encoder = std::max(
      std::hypot(sensors.encoders.angle.absolute, sensors.encoders.Resolution() / std::sqrt(12)), 1e-5);
  return noise;
}

}  // namespace tenon::apps
