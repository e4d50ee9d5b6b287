#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/plants/attached_bodies.h>
#include <tenon/plants/robots/load_robot.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon::apps {
namespace {

QuadrupedDescription ReadRobot(const LeggedScenario& scenario) {
  return Blame("robot", [&] { return LoadQuadruped(scenario.robot); });
}

/// The centre of the hips' pitch axes with all joints at 0, in B [m].
Vec<3> CentreOfHips(const QuadrupedDescription& robot) {
  Vec<3> centre = Vec<3>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg)
    centre += robot.HipPosition(leg, Vec<kNumJoints>::Zero()) / kNumLegs;
  return centre;
}

SizeRatio ReadRatio(const LeggedScenario& scenario, const QuadrupedDescription& robot) {
  if (!scenario.scale_forces) return {};
  const QuadrupedDescription dogbot = LoadQuadruped(YamlFile{"dogbot"});
  const RobotScale scale = ScaleOf(robot), own = ScaleOf(dogbot);
  const double length = scale.length / own.length;
  return {scale.mass / own.mass, length, CentreOfHips(robot) - length * CentreOfHips(dogbot)};
}

/// Returns the point of the robot on which a force acts, with a force of zero.
ExternalForce PointOf(const QuadrupedDescription& robot, const ForceScenario& force) {
  if (force.on == Part::kTrunk) return {};
  return PointOnLeg(robot, static_cast<int>(force.on) - static_cast<int>(Part::kFrontLeft), force.height);
}

void AddForce(const ForceScenario& force, QuadrupedWorldParams& world) {
  ExternalForce push = PointOf(world.plant.robot, force);
  push.force_W = force.force_N;
  push.torque_W = force.torque_N_m;
  if (force.factor != 1 || force.turn_rad != 0) {
    const Eigen::Matrix3d turn =
        force.factor * Eigen::AngleAxisd(force.turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    push.force_W = turn * push.force_W;
    push.torque_W = turn * push.torque_W;
  }
  if (force.frequency_rad_per_s > 0)
    world.sines.push_back({push, force.frequency_rad_per_s, force.start_s, force.start_s + force.duration_s});
  else
    world.pulses.push_back({push, force.start_s, force.duration_s});
}

void SetPayload(const TrunkLoadScenario& payload, double stance_height, QuadrupedWorldParams& world) {
  const double lowest = payload.position_m.z() - payload.edges_m.z() / 2;
  if (payload.mass_kg > 0 && lowest < -stance_height)
    throw KeyError("payload.position_m",
                   fmt::format("the payload reaches {:.3g} m below the trunk, which stands only {:.3g} m "
                               "above the ground: lift it",
                               -lowest, stance_height));
  if (payload.slides && payload.mass_kg > 0) {
    world.sliding_load = payload.slides;
    world.sliding_load->mass = payload.mass_kg;
    world.sliding_load->position_B = payload.position_m;
  } else {
    world.plant.payload = UniformBoxInertia(payload.mass_kg, payload.position_m, payload.edges_m);
  }
}

void SetFall(const FallScenario& fall, double stance_height, QuadrupedWorldParams& world) {
  world.min_height = fall.min_height_ratio * stance_height;
  world.max_tilt = fall.max_tilt_rad;
  world.max_height = fall.max_height_m;
  if (world.max_height <= world.min_height)
    throw KeyError("fall.max_height_m",
                   fmt::format("{} must be above {:.3g}, the height below which the robot has fallen",
                               world.max_height, world.min_height));
}

/// The world of a scenario that is scaled to this robot. `rate` is the sample rate of the controller.
QuadrupedWorldParams MakeWorldParams(const QuadrupedScenario& scenario, const QuadrupedDescription& robot,
                                     Rate rate, SlowOptions* mpc = nullptr) {
  TerrainParams terrain = scenario.terrain;
  if (terrain.field) terrain.field->seed += scenario.seed;  // so that the layout depends on the run's seed
  QuadrupedWorldParams world = Blame("terrain", [&] { return MakeQuadrupedWorld(robot, terrain); });
  world.plant.limit_speed = scenario.limit_speed;
  world.plant.initial.p_WB[2] += scenario.start_height_m;
  SetPayload(scenario.payload, robot.StanceHeight(), world);
  MovingParts moving = LoadMovingParts(scenario.robot);
  moving.bodies.insert(moving.bodies.end(), scenario.attached.begin(), scenario.attached.end());
  if (scenario.dynamics == Dynamics::kSimbody) world.plant.extend = [](QuadrupedMultibody&) {};
  if (!moving.bodies.empty()) world.plant.extend = Attach(moving.bodies, moving.at_rest);
  Blame("hardware", [&] {
    SetHardware(LoadHardware(scenario.hardware, ScaleOf(robot, world.plant.gravity), scenario.sensors), rate,
                world, mpc);
  });
  for (const ForceScenario& force : scenario.forces) AddForce(force, world);
  for (const RandomForceScenario& force : scenario.random_forces)
    world.random.push_back({robot, force.on_trunk, force.lower_N, force.upper_N, Seconds(force.period_s)});
  SetFall(scenario.fall, robot.StanceHeight(), world);
  return world;
}

/// The controller's model of the robot.
QuadrupedDescription MakeModel(const WalkScenario& walk, const QuadrupedDescription& robot,
                               const DriveProperties& drive, std::uint64_t seed) {
  RandomStream errors(seed, "walk.model_error");
  QuadrupedDescription model =
      WithModelError(WithMassFactor(robot, 1 + walk.mass_error_ratio), walk.model_error, errors);
  // A rotor inertia from the data sheet of the hardware is known to the controller.
  if (drive.rotor_inertia != robot.drive.rotor_inertia) model.drive.rotor_inertia = drive.rotor_inertia;
  return model;
}

/// The filter has the controller's model and the noise of the sensors, but not their biases. Its initial
/// state differs from the true one by a random error with the filter's own initial deviations.
LeggedStateEstimatorParams MakeEstimator(const QuadrupedSensors& sensors, const QuadrupedDescription& model,
                                         const QuadrupedPlantParams& plant, std::uint64_t seed) {
  LeggedStateEstimatorParams params;
  params.robot = model;
  params.initial = plant.initial;
  params.gravity = plant.gravity;
  params.noise = BelievedNoise(sensors);
  RandomStream random(seed, "walk.state");
  const LeggedStartDeviation& start = params.start;
  const Vec<3> turn = NormalVector(random, Vec<3>::Constant(start.attitude));
  params.initial.q_WB = QuaternionProduct(QuaternionFromRotationVector(turn), params.initial.q_WB);
  params.initial.p_WB += NormalVector(random, Vec<3>::Constant(start.position));
  params.initial.v_W += NormalVector(random, Vec<3>::Constant(start.velocity));
  return params;
}

}  // namespace

SizeRatio RatioOf(const LeggedScenario& scenario) {
  return scenario.scale_forces ? ReadRatio(scenario, ReadRobot(scenario)) : SizeRatio();
}

QuadrupedScenario ScaledToRobot(QuadrupedScenario scenario, const SizeRatio& ratio) {
  const auto& [weight, length, offset] = ratio;
  for (ForceScenario& force : scenario.forces) {
    force.force_N *= weight;
    force.torque_N_m *= weight * length;
  }
  for (RandomForceScenario& force : scenario.random_forces) {
    force.lower_N *= weight;
    force.upper_N *= weight;
  }
  for (Rope& rope : scenario.ropes) {
    rope.attachment_B = length * rope.attachment_B + offset;
    rope.tension_min *= weight;
    rope.tension_max *= weight;
  }
  TrunkLoadScenario& payload = scenario.payload;
  payload.mass_kg *= weight;
  payload.position_m = length * payload.position_m + offset;
  payload.edges_m *= length;
  if (payload.slides) payload.slides->reach *= length;
  for (TerrainBox& box : scenario.terrain.boxes) {
    box.size *= length;
    box.height *= length;
  }
  if (scenario.terrain.stairs) {
    scenario.terrain.stairs->rise *= length;
    scenario.terrain.stairs->run *= length;
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

QuadrupedStandParams MakeStandParams(const QuadrupedScenario& given) {
  const QuadrupedDescription robot = ReadRobot(given);
  const QuadrupedScenario scenario = ScaledToRobot(given, ReadRatio(given, robot));
  const JointPdScenario& pd = *scenario.pd;
  QuadrupedStandParams params;
  params.world = MakeWorldParams(scenario, robot, Hz(pd.rate_hz));
  params.pd = MakeJointPd(robot);
  params.pd.stiffness = pd.stiffness_N_m_per_rad.value_or(params.pd.stiffness);
  params.pd.damping = pd.damping_N_m_s_per_rad.value_or(params.pd.damping);
  params.pd.gravity_compensation = pd.gravity_compensation;
  params.pd.rate = Hz(pd.rate_hz);
  params.pd.gravity = params.world.plant.gravity;
  return params;
}

QuadrupedWalkParams MakeWalkParams(const QuadrupedScenario& given) {
  const QuadrupedDescription robot = ReadRobot(given);
  QuadrupedScenario scenario = ScaledToRobot(given, ReadRatio(given, robot));
  double& load = scenario.payload.mass_kg;
  if (scenario.scale_forces && load > 0) load = std::min(load, HeldByTwoLegs(robot).load);
  const WalkScenario& walk = *scenario.walk;
  EndOfWalk(walk);  // throws for a path that cannot be walked
  SlowOptions calculation;
  QuadrupedWorldParams world =
      MakeWorldParams(scenario, robot, WholeBodyParams().rate, walk.mpc ? &calculation : nullptr);
  if (scenario.deployment && scenario.deployment->initial == DeploymentMode::kPassive) {
    QuadrupedDescription lying = robot;
    lying.stance = LyingPosture(robot);
    world.plant.initial = StandingOn(lying, {});
  }
  const QuadrupedDescription model = MakeModel(walk, robot, world.plant.robot.drive, scenario.seed);
  // Profile and gaits are scaled to the true robot, whatever model of it the controller has.
  const RobotScale scale = ScaleOf(robot);
  QuadrupedWalkParams params = MakeQuadrupedWalk(
      world, model, Blame("profile", [&] { return LoadLocomotionProfile(scenario.profile, scale); }),
      Blame("walk.gaits", [&] { return LoadGaits(walk.gaits, scale); }));
  if (!scenario.ropes.empty())
    Blame("ropes", [&] { AddRopes(scenario.ropes, &params, scenario.start_height_m); });
  params.walk = walk.path;
  params.locomotion.pace = walk.pace;
  params.locomotion.mpc = walk.mpc;
  params.locomotion.calculation = calculation;
  if (walk.mpc) Blame("walk.mpc", [&] { CentroidalMpcParams{.robot = model, .mpc = *walk.mpc}.Validate(); });
  params.locomotion.mapped = walk.terrain_map.has_value();
  if (walk.terrain_map)
    params.map = {.terrain = world.plant.terrain, .map = *walk.terrain_map, .seed = scenario.seed};
  params.locomotion.com_planner.reference = walk.com_reference;
  params.locomotion.com_planner.zmp = walk.zmp;
  params.locomotion.com_planner.trajectory = walk.trajectory;
  params.locomotion.swing_planner.step = walk.step;
  if (walk.friction) params.locomotion.whole_body.gains.qp.friction = *walk.friction;
  params.known_additions = scenario.known_additions;
  if (scenario.deployment) {
    params.deployment = scenario.deployment;
    params.deployment->robot = model;
    params.deployment->gravity = world.plant.gravity;
  }
  if (scenario.observer) params.observer.kind = *scenario.observer;
  if (walk.state == StateSource::kEstimated)
    params.estimator = MakeEstimator(params.world, model, params.world.plant, scenario.seed);
  return params;
}

std::vector<std::string> Notes(const QuadrupedScenario& scenario) {
  std::vector<std::string> notes;
  if (!scenario.walk) return notes;
  const QuadrupedDescription robot = ReadRobot(scenario);
  const HeldMass held = HeldByTwoLegs(robot);
  if (held.mass < robot.mass()) notes.push_back(CannotHold(robot, held));
  const double load = scenario.payload.mass_kg * ReadRatio(scenario, robot).weight;
  if (load <= held.load) return notes;
  const JointDescription& joint = robot.joint(held.joint);
  notes.push_back(fmt::format(
      "payload: {:.3g} kg, {:.0f} % of the robot's weight, are more than the {:.3g} kg that two legs hold "
      "beside the robot by the {:.3g} N m of joint '{}'; {}",
      load, 100 * load / robot.mass(), held.load, joint.torque_limit, joint.name,
      scenario.scale_forces ? "reduced to this mass" : "the robot may fall"));
  return notes;
}

}  // namespace tenon::apps
