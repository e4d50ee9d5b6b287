#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/checks.h>
#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/notes.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/plants/model/robot_scale.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/yaml/resources.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenon::apps {
namespace {

/// Where a force acts, without the force.
ExternalForce PointOf(const QuadrupedDescription& robot, const ForceScenario& force) {
  if (force.on == Part::kTrunk) return {};
  return PointOnLeg(robot, static_cast<int>(force.on) - static_cast<int>(Part::kFrontLeft), force.height);
}

/// When it ends [s].
double EndOfWalk(const WalkScenario& walk) {
  return Blame("walk.path", [&] { return WalkSchedule(walk.path).end_time(); });
}

QuadrupedDescription LoadRobot(const QuadrupedScenario& scenario) {
  return Blame("robot", [&] { return LoadQuadruped(scenario.robot); });
}

HardwareScenario HardwareOf(const QuadrupedScenario& scenario) {
  return WithSensors(Blame("hardware", [&] { return LoadHardware(scenario.hardware); }), scenario.sensors);
}

/// The filter knows the robot that the controller believes in, where it starts but for what its deviations
/// say, and its sensors' noise; it takes none for perfect and does not know their biases.
LeggedStateEstimatorParams MakeEstimator(const HardwareScenario& hardware,
                                         const QuadrupedDescription& believed,
                                         const QuadrupedPlantParams& plant, std::uint64_t seed) {
  LeggedStateEstimatorParams params;
  params.robot = believed;
  params.initial = plant.initial;
  params.gravity = plant.gravity;
  params.noise = BelievedNoise(hardware);
  RandomStream random(seed, "walk.state");
  const LeggedStartDeviation& start = params.start;
  const Vec<3> turn = NormalVector(random, Vec<3>::Constant(start.attitude));
  params.initial.q_WB = QuaternionProduct(QuaternionFromRotationVector(turn), params.initial.q_WB);
  params.initial.p_WB += NormalVector(random, Vec<3>::Constant(start.position));
  params.initial.v_W += NormalVector(random, Vec<3>::Constant(start.velocity));
  return params;
}

QuadrupedWorldParams MakeWorldParams(const QuadrupedScenario& scenario, const QuadrupedDescription& robot,
                                     const HardwareScenario& hardware, Rate rate) {
  TerrainParams terrain = scenario.terrain;
  if (terrain.field) terrain.field->seed += scenario.seed;  // each seed has a layout of its own
  QuadrupedWorldParams params = Blame("terrain", [&] { return MakeQuadrupedWorld(robot, terrain); });
  QuadrupedPlantParams& plant = params.plant;
  const TrunkLoadScenario& payload = scenario.payload;
  if (payload.slides && payload.mass_kg > 0)
    params.sliding_load = SlidingLoadParams{.mass = payload.mass_kg,
                                            .position_B = payload.position_m,
                                            .reach = payload.slides->reach_m,
                                            .friction = payload.slides->friction};
  else
    plant.payload = payload.Make();
  plant.limit_speed = scenario.limit_speed;
  plant.initial.p_WB[2] += scenario.start_height_m;

  SetHardware(hardware, rate, params);

  for (const ForceScenario& force : scenario.forces) {
    ExternalForce push = PointOf(robot, force);
    push.force_W = force.force_N;
    push.torque_W = force.torque_N_m;
    if (force.factor != 1 || force.turn_rad != 0) {
      const Eigen::Matrix3d turn =
          force.factor * Eigen::AngleAxisd(force.turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      push.force_W = turn * push.force_W;
      push.torque_W = turn * push.torque_W;
    }
    if (force.frequency_rad_per_s > 0)
      params.sines.push_back(
          {push, force.frequency_rad_per_s, force.start_s, force.start_s + force.duration_s});
    else
      params.pulses.push_back({push, force.start_s, force.duration_s});
  }
  for (const RandomForceScenario& force : scenario.random_forces)
    params.random.push_back({robot, force.on_trunk, force.lower_N, force.upper_N, Seconds(force.period_s)});
  params.min_height = scenario.fall.min_height_ratio * robot.StanceHeight();
  params.max_tilt = scenario.fall.max_tilt_rad;
  params.max_height = scenario.fall.max_height_m;
  if (params.max_height <= params.min_height)
    throw KeyError("fall.max_height_m", fmt::format("{} must be above {:.3g}, where it has fallen",
                                                    params.max_height, params.min_height));
  const double lowest = payload.position_m.z() - payload.edges_m.z() / 2;
  if (payload.mass_kg > 0 && lowest < -robot.StanceHeight())
    throw KeyError("payload.position_m",
                   fmt::format("the load reaches down to {:.3g} m below the trunk, which "
                               "stands {:.3g} m above the ground: lift it",
                               -lowest, robot.StanceHeight()));
  return params;
}

}  // namespace

void JointPdScenario::Validate() const {
  if (stiffness_N_m_per_rad) DemandNotNegative("stiffness_N_m_per_rad", *stiffness_N_m_per_rad);
  if (damping_N_m_s_per_rad) DemandNotNegative("damping_N_m_s_per_rad", *damping_N_m_s_per_rad);
  DemandRate("rate_hz", rate_hz);
}

void WalkScenario::Validate() const {
  if (friction) DemandPositive("friction", *friction);
  DemandNotNegative("judged_from_s", judged_from_s);
  DemandPositive("path_tolerance", path_tolerance);
  Demand(
      std::isfinite(mass_error_ratio) && mass_error_ratio > -1,
      fmt::format("mass_error_ratio = {} must be above -1: the robot would have no mass", mass_error_ratio));
}

void LiveScenario::Validate() const {
  const auto range = [](const char* key, const Vec<2>& limits) {
    Demand(limits.allFinite() && limits[0] <= 0 && limits[1] >= 0,
           fmt::format("{} = [{}, {}]: give the least, 0 or less, and the largest, 0 or more", key, limits[0],
                       limits[1]));
  };
  range("forward_m_per_s", forward_m_per_s);
  range("sideways_m_per_s", sideways_m_per_s);
  range("yaw_rad_per_s", yaw_rad_per_s);
  DemandNotNegative("squat_m", squat_m);
  DemandPositive("load_ratio", load_ratio);
}

void FallScenario::Validate() const {
  Demand(min_height_ratio >= 0 && min_height_ratio < 1,
         fmt::format("min_height_ratio = {} must be at least 0 and below 1: the stance would be a fall",
                     min_height_ratio));
  DemandBetween("max_tilt_rad", max_tilt_rad, 1e-3, std::numbers::pi);
  DemandPositive("max_height_m", max_height_m);
}

void ForceScenario::Validate() const {
  DemandBetween("height", height, 0, 1);
  DemandNotNegative("duration_s", duration_s);
  DemandNotNegative("frequency_rad_per_s", frequency_rad_per_s);
}

void SlideScenario::Validate() const {
  Demand(reach_m.allFinite() && reach_m.minCoeff() >= 0,
         fmt::format("reach_m = [{}, {}] must not be negative", reach_m[0], reach_m[1]));
  DemandBetween("friction", friction, 0, 10);
}

void TrunkLoadScenario::Validate() const {
  DemandBetween("mass_kg", mass_kg, 0, 1e6);
  DemandNear("position_m", position_m);
  constexpr double kFar = 100;  // m: beyond that it lies on no robot
  Demand(edges_m.allFinite() && edges_m.minCoeff() >= 0 && edges_m.maxCoeff() <= kFar,
         fmt::format("edges_m = [{}, {}, {}] must not be negative, and within {} m", edges_m[0], edges_m[1],
                     edges_m[2], kFar));
}

void SweepScenario::Validate() const {
  constexpr int kMost = 10000;  // runs
  Demand(phases <= kMost && directions <= kMost && static_cast<long>(phases) * directions <= kMost,
         fmt::format("a sweep over {} phases and {} directions: {} runs are the most; more are for "
                     "tenon-campaign",
                     phases, directions, kMost));
  Demand(phases > 0 && directions > 0 && period_s > 0,
         fmt::format("a sweep over {} phases of {} s and {} directions: all must be positive", phases,
                     period_s, directions));
}

void RandomForceScenario::Validate() const {
  DemandSamplePeriod("period_s", period_s);
  DemandNotNegative("lower_N", lower_N);
  Demand(std::isfinite(upper_N) && upper_N >= lower_N,
         fmt::format("upper_N = {} must not be below lower_N = {}", upper_N, lower_N));
}

RigidInertia TrunkLoadScenario::Make() const {
  const Eigen::Vector3d squares = edges_m.cwiseAbs2();
  RigidInertia load;
  load.mass = mass_kg;
  load.com = position_m;
  load.inertia.diagonal() = mass_kg / 12 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
  return load;
}

void QuadrupedScenario::Validate() const {
  if (duration_s) DemandPositive("duration_s", *duration_s);
  Demand(pd.has_value() != walk.has_value(),
         fmt::format("a robot either stands by joint PD or walks: give one of pd and walk, not {}",
                     pd ? "both; set the other to null" : "none"));
  Demand(!sweep || (walk && !forces.empty()), "a sweep needs a walk and a force: give walk and forces");
  Demand(start_height_m >= 0,
         fmt::format("start_height_m = {} must not be negative: the feet would start in the ground",
                     start_height_m));
  DemandRate("log_rate_hz", log_rate_hz);
  // One more is a pull of whoever watches, and one a load that slides.
  const std::size_t most = kMaxExternalForces - (payload.slides ? 2 : 1);
  const std::size_t num_forces = forces.size() + random_forces.size();
  Demand(num_forces <= most,
         fmt::format("{}: {} forces, those of random_forces among them, are too many: {} are the most",
                     forces.empty() ? "random_forces" : "forces", num_forces, most));
}

JointPdParams JointPdScenario::For(const QuadrupedDescription& robot) const {
  JointPdParams params = MakeJointPd(robot);
  params.stiffness = stiffness_N_m_per_rad.value_or(params.stiffness);
  params.damping = damping_N_m_s_per_rad.value_or(params.damping);
  params.gravity_compensation = gravity_compensation;
  params.rate = Hz(rate_hz);
  return params;
}

SizeRatio RatioOf(const QuadrupedScenario& scenario) {
  if (!scenario.scale_forces) return {};
  const RobotScale robot = ScaleOf(LoadRobot(scenario)), dogbot = ScaleOf(LoadQuadruped(YamlFile{"dogbot"}));
  return {robot.mass / dogbot.mass, robot.length / dogbot.length};
}

QuadrupedScenario ScaledToRobot(QuadrupedScenario scenario) {
  const auto [weight, length] = RatioOf(scenario);
  scenario.scale_forces = false;
  for (ForceScenario& force : scenario.forces) {
    force.force_N *= weight;
    force.torque_N_m *= weight * length;
  }
  for (RandomForceScenario& force : scenario.random_forces) {
    force.lower_N *= weight;
    force.upper_N *= weight;
  }
  TrunkLoadScenario& payload = scenario.payload;
  payload.mass_kg *= weight;
  payload.position_m *= length;
  payload.edges_m *= length;
  if (payload.slides) payload.slides->reach_m *= length;
  for (TerrainBox& box : scenario.terrain.boxes) {
    box.size *= length;
    box.height *= length;
  }
  if (scenario.terrain.field) {
    BoxField& field = *scenario.terrain.field;
    field.size *= length;
    field.gap *= length;
    for (BoxKind& kind : field.kinds) kind.height *= length;
  }
  if (scenario.walk) {
    StepProperties& step = scenario.walk->step;
    for (double* const part :
         {&step.height, &step.touchdown_speed, &step.search_depth, &step.free_shift, &step.free_offset,
          &step.largest_shift, &step.reflex.lag, &step.reflex.retreat, &step.reflex.height})
      *part *= length;
  }
  return scenario;
}

PathVerdict MakePathVerdict(const WalkScenario& walk, bool live) {
  if (live) return {};
  const WalkSchedule::Extent way = WalkSchedule(walk.path).extent();
  if (way.length == 0 && way.turn == 0) return {};
  return {walk.path_tolerance, way.length};
}

void AddNotes(const std::vector<ForceScenario>& forces, double duration, std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const ForceScenario& force = forces[i];
    const bool none = force.factor == 0 || (force.force_N.isZero(0) && force.torque_N_m.isZero(0));
    AddIdle(fmt::format("forces.{}", i), {.start = force.start_s, .length = force.duration_s}, duration,
            none ? "force_N and torque_N_m, times factor, are 0" : "", notes);
  }
}

std::vector<std::string> Notes(const QuadrupedScenario& scenario, double duration) {
  std::vector<std::string> notes;
  AddNotes(scenario.forces, duration, notes);
  for (std::size_t i = 0; i < scenario.random_forces.size(); ++i)
    AddIdle(fmt::format("random_forces.{}", i), {}, duration,
            scenario.random_forces[i].upper_N == 0 ? "upper_N is 0" : "", notes);
  const TrunkLoadScenario& payload = scenario.payload;
  const bool placed = payload.slides || !payload.position_m.isZero(0) || !payload.edges_m.isZero(0);
  AddIdle("payload", {}, duration, placed && payload.mass_kg == 0 ? "mass_kg is 0" : "", notes);
  AddNotes(scenario.faults, duration, notes);
  return notes;
}

double Duration(const QuadrupedScenario& scenario) {
  if (scenario.duration_s) return *scenario.duration_s;
  return scenario.walk ? EndOfWalk(*scenario.walk) + 1 : 10;
}

QuadrupedStandParams MakeStandParams(const QuadrupedScenario& scenario) {
  if (scenario.scale_forces) return MakeStandParams(ScaledToRobot(scenario));
  const QuadrupedDescription robot = LoadRobot(scenario);
  QuadrupedStandParams params;
  params.world = MakeWorldParams(scenario, robot, HardwareOf(scenario), Hz(scenario.pd->rate_hz));
  params.pd = scenario.pd->For(robot);
  params.pd.gravity = params.world.plant.gravity;
  return params;
}

QuadrupedWalkParams MakeWalkParams(const QuadrupedScenario& scenario) {
  if (scenario.scale_forces) return MakeWalkParams(ScaledToRobot(scenario));
  const WalkScenario& walk = *scenario.walk;
  const QuadrupedDescription robot = LoadRobot(scenario);
  const HardwareScenario hardware = HardwareOf(scenario);
  const QuadrupedWorldParams world = MakeWorldParams(scenario, robot, hardware, WholeBodyParams().rate);
  EndOfWalk(walk);  // what cannot be walked is refused here, with its key
  RandomStream errors(scenario.seed, "walk.model_error");
  QuadrupedDescription believed =
      WithModelError(WithMassFactor(robot, 1 + walk.mass_error_ratio), walk.model_error, errors);
  const double rotor_inertia = world.plant.robot.drive.rotor_inertia;
  if (rotor_inertia != robot.drive.rotor_inertia)
    believed.drive.rotor_inertia = rotor_inertia;  // of a data sheet
  const RobotScale scale = ScaleOf(robot);  // the robot as built: what it is believed to be is another matter
  LocomotionProfile profile =
      Blame("profile", [&] { return LoadLocomotionProfile(scenario.profile, scale); });
  if (scenario.observer) profile.observer.kind = *scenario.observer;
  QuadrupedWalkParams params = MakeQuadrupedWalk(world, profile, believed);
  params.walk = walk.path;
  params.locomotion.scheduler = Blame("walk.gaits", [&] { return LoadGaits(walk.gaits, scale); });
  params.locomotion.com_planner.reference = walk.com_reference;
  params.locomotion.com_planner.zmp = walk.zmp;
  params.locomotion.swing_planner.step = walk.step;
  if (walk.friction) params.locomotion.whole_body.gains.qp.friction = *walk.friction;
  if (walk.state == StateSource::kEstimated)
    params.estimator = MakeEstimator(hardware, believed, params.world.plant, scenario.seed);
  return params;
}

std::vector<std::pair<std::string, QuadrupedScenario>> SweepOf(const QuadrupedScenario& scenario) {
  const SweepScenario& sweep = *scenario.sweep;
  std::vector<std::pair<std::string, QuadrupedScenario>> runs;
  for (int phase = 0; phase < sweep.phases; ++phase) {
    for (int direction = 0; direction < sweep.directions; ++direction) {
      QuadrupedScenario run = scenario;
      run.sweep.reset();
      ForceScenario& force = run.forces.front();
      force.start_s += sweep.period_s * phase / sweep.phases;
      force.force_N =
          Eigen::AngleAxisd(2 * std::numbers::pi * direction / sweep.directions, Eigen::Vector3d::UnitZ()) *
          force.force_N;
      runs.emplace_back(fmt::format("phase_{}_direction_{}", phase, direction), run);
    }
  }
  return runs;
}

SimulatorOptions MakeSimulatorOptions(const QuadrupedScenario& scenario) {
  SimulatorOptions options = scenario.integrator.Options("loop.world.plant");
  options.seed = scenario.seed;
  return options;
}

}  // namespace tenon::apps
