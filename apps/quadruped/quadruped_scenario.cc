#include <tenon/apps/quadruped/legged_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

void RandomForceScenario::Validate() const {
  Demand(std::isfinite(upper_N) && upper_N >= lower_N,
         fmt::format("upper_N = {} must not be below lower_N = {}", upper_N, lower_N));
}

void QuadrupedScenario::Validate() const {
  Demand(!pd || !walk, "pd and walk are both given: set pd to null for a walk, or walk to null for standing");
  Demand(pd || walk, "neither pd nor walk is given: give pd for a robot that stands, or walk");
  Demand(ropes.empty() || walk,
         "ropes: a standing robot has no control of the tensions; give walk, or no ropes");
  Demand(!deployment || walk, "deployment: only a walk has a supervisor; give walk, or set it to null");
  if (!ropes.empty()) CheckRopes(ropes);
  // One force is reserved for QuadrupedWorld::pull, and one for a load that slides.
  const std::size_t most = kMaxExternalForces - (payload.slides ? 2 : 1);
  const std::size_t num_forces = forces.size() + random_forces.size();
  Demand(num_forces <= most,
         fmt::format("{}: {} forces (forces and random_forces) are too many, at most {} are possible",
                     forces.empty() ? "random_forces" : "forces", num_forces, most));
}

double Duration(const QuadrupedScenario& scenario) {
  if (scenario.duration_s) return *scenario.duration_s;
  return scenario.walk ? EndOfWalk(*scenario.walk) + 1 : 10;
}

void LiveScenario::Validate() const {
  const auto range = [](const char* key, const Vec<2>& limits) {
    Demand(limits.allFinite() && limits[0] <= 0 && limits[1] >= 0,
           fmt::format("{} = [{}, {}] must contain 0: give the least value, then the largest one", key,
                       limits[0], limits[1]));
  };
  range("forward_m_per_s", forward_m_per_s);
  range("sideways_m_per_s", sideways_m_per_s);
  range("yaw_rad_per_s", yaw_rad_per_s);
}

PathVerdict MakePathVerdict(const WalkScenario& walk, bool live) {
  if (live) return {};
  const WalkSchedule::Extent extent = WalkSchedule(walk.path).extent();
  if (extent.length == 0 && extent.turn == 0) return {};
  return {walk.path_tolerance, extent.length};
}

double EndOfWalk(const WalkScenario& walk) {
  return Blame("walk.path", [&] { return WalkSchedule(walk.path).end_time(); });
}

SimulatorOptions MakeSimulatorOptions(const LeggedScenario& scenario, const QuadrupedPlant& plant) {
  if (!LoadPlace(scenario.robot).empty())
    throw KeyError("robot.link",
                   "only a run of tenon-quadruped drives a robot: remove this key to simulate it");
  SimulatorOptions options = scenario.integrator.Options(plant);
  options.seed = scenario.seed;
  return options;
}

std::string Describe(const LeggedScenario& scenario, double duration) {
  return fmt::format("{}, {:.4g} s, seed {}", ResourceName(scenario.robot), duration, scenario.seed);
}

QuadrupedHardware LoadHardware(const YamlFile& file, const Scale& scale, const SensorChanges& sensors) {
  YamlDocument document = LoadResource("hardware/legged", file);
  document.Change("sensors", sensors);
  return document.Read<QuadrupedHardware>(&scale);
}

MeanLimits::MeanLimits(const QuadrupedDescription& robot) {
  for (int j = 0; j < kNumJoints; ++j) {
    torque += robot.joint(j).torque_limit / kNumJoints;
    speed += robot.joint(j).speed_limit / kNumJoints;
  }
}

/// All drives are equal.
static void SetDrives(const DriveRatings& drives, Rate rate, QuadrupedWorldParams& world) {
  const auto [torque, speed] = MeanLimits(world.plant.robot);
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

HeldMass HeldByTwoLegs(const QuadrupedDescription& robot) {
  const Vec<kNumJoints> torque = 2 * StandingTorque(robot, kGravity);  // a foot carries half of the weight
  constexpr double kAny = std::numeric_limits<double>::infinity();
  HeldMass held{.mass = kAny, .load = kAny};
  for (int j = 0; j < kNumJoints; ++j) {
    const double mass = robot.mass() * robot.joint(j).torque_limit / std::abs(torque[j]);
    if (mass < held.mass) held = {mass, std::max(0.0, mass - robot.mass()), j, std::abs(torque[j])};
  }
  return held;
}

std::string CannotHold(const QuadrupedDescription& robot, const HeldMass& held) {
  const JointDescription& joint = robot.joint(held.joint);
  return fmt::format(
      "in a trot, two legs hold the robot, for which joint '{}' needs {:.3g} N m in the nominal stance, but "
      "its limit is {:.3g} N m: the robot may fall",
      joint.name, held.torque, joint.torque_limit);
}

}  // namespace tenon::apps
