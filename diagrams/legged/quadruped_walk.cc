#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/core.h>

namespace tenon {

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const QuadrupedDescription& model,
                                      const LocomotionProfile& profile, const FootSchedulerParams& gaits) {
  QuadrupedWalkParams params;
  params.world = world;
  params.locomotion = MakeLocomotion(model, profile, gaits);
  params.observer = MakeObserver(model, profile);
  return params;
}

QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot) {
  const RobotScale scale = ScaleOf(robot);
  return MakeQuadrupedWalk(MakeQuadrupedWorld(robot), robot, LoadLocomotionProfile({"standard"}, scale),
                           LoadGaits({"standard"}, scale));
}

/// Throws ParameterError unless the initial tensions leave the feet on `ground` a force within their friction
/// or, if the robot hangs, little of its weight; it may then swing.
static void DemandHold(const QuadrupedRopesParams& ropes, const QuadrupedDescription& robot,
                       const LeggedState& initial, const Terrain::Surface& ground, bool hangs) {
  const double part = hangs ? 0.1 : 0.001;  // tolerance, as a part of the weight
  const double weight = robot.mass() * kGravity;
  Eigen::Vector3d rest = weight * Eigen::Vector3d::UnitZ();
  for (std::size_t i = 0; i < ropes.ropes.size(); ++i)
    rest -= ropes.initial_tension[static_cast<Eigen::Index>(i)] * LineOf(ropes.ropes[i], initial).direction_W;
  const double along_normal = rest.dot(ground.normal_W);
  const double slip = (rest - along_normal * ground.normal_W).norm() - ground.friction * along_normal;
  const double missing = hangs ? rest[2] : std::max(slip, -along_normal);
  Demand(missing <= part * weight,
         fmt::format(
             "the ropes cannot hold the robot at the start: within their tensions, {:.3g} N of its "
             "weight of {:.3g} N are left, which {}; move anchors or attachments, raise tension_max_N, "
             "or add a rope",
             missing, weight, hangs ? "nothing carries while it hangs" : "exceed the friction of its feet"));
}

void AddRopes(const std::vector<Rope>& ropes, QuadrupedWalkParams* params, double height) {
  QuadrupedPlantParams& plant = params->world.plant;
  const Terrain::Surface ground = Terrain(plant.terrain).At(0, 0);
  const Vec<2> uphill = -ground.normal_W.head<2>();
  const GroundPlane plane{.p_W = {0, 0, ground.height}, .slope = uphill / ground.normal_W[2]};
  const double com_height = NominalStance(plant.robot).com_height;
  plant.initial = StandingOn(plant.robot, plane, 0, com_height * ground.normal_W[2] * uphill);
  plant.initial.p_WB[2] += height;
  for (const Rope& rope : ropes)
    Demand(
        !(rope.anchor_W - plant.initial.p_WB - plant.initial.R_WB() * rope.attachment_B).isZero(1e-3),
        fmt::format("the anchor of the rope '{}' coincides with its attachment: move it away from the robot",
                    rope.name));
  ContactSchedule schedule;
  if (height > 0)
    for (LegContact& leg : schedule.legs) leg.state = ContactState::kSearching;
  const RopeTensions tensions({.robot = params->locomotion.whole_body.robot, .ropes = ropes});
  params->ropes = {.ropes = ropes, .initial_tension = tensions.CommandAt(plant.initial, plane, schedule)};
  DemandHold(*params->ropes, params->locomotion.whole_body.robot, plant.initial, ground, height > 0);
}

QuadrupedWalk::QuadrupedWalk(const QuadrupedWalkParams& params)
    : walk(Add<WalkSchedule>("walk", params.walk)),
      locomotion(Add<LeggedLocomotion>("locomotion", params.locomotion)),
      world(Add<QuadrupedWorld>("world", params.world)),
      observer(Add<DisturbanceObserver>("observer", params.observer)),
      errors(Add<TrackingError>("errors", TrackingErrorParams{params.world.plant.robot})),
      view(Add<WalkView>("view", WalkViewParams{params.world.plant.robot})),
      state(AddEstimator(params.estimator)) {
  const OutputPort<FootForces>& foot_forces = AddFootForces(params.world);
  Connect(state, locomotion.state);
  Connect(foot_forces, locomotion.foot_forces);
  Connect(observer.leg_forces, locomotion.leg_forces);
  if (!params.deployment) Connect(locomotion.torque, world.torque);
  if (params.locomotion.mapped) {
    map = &Add<TerrainMapper>("map", params.map);
    Connect(world.state, map->state);
    Connect(state, map->told);
    Connect(map->map, locomotion.map);
  }
  ConnectWrenches(params);
  const OutputPort<WalkCommand>& command = params.ropes ? AddStop() : walk.command;
  Connect(params.deployment ? AddDeployment(*params.deployment, command) : command, locomotion.command);
  ConnectObserver(foot_forces);
  ConnectEvaluation();
}

const OutputPort<LeggedState>& QuadrupedWalk::AddEstimator(
    const std::optional<LeggedStateEstimatorParams>& params) {
  if (!params) return world.state;
  estimator = &Add<LeggedStateEstimator>("estimator", *params);
  Connect(world.inertial, estimator->imu);
  Connect(world.joints, estimator->joints);
  Connect(locomotion.schedule, estimator->schedule);
  return estimator->state;
}

/// Adds the block that computes the foot forces in W, if the sensors do not measure them there.
const OutputPort<FootForces>& QuadrupedWalk::AddFootForces(const QuadrupedWorldParams& params) {
  const FootSensing sensing = params.foot_sensor.mounted;
  if (sensing == FootSensing::kWorld) return world.foot_forces;
  if (sensing == FootSensing::kNone) {
    FootForcesOfLegsParams of_legs{.robot = locomotion.whole_body.params.robot,
                                   .rate = locomotion.scheduler.params.rate};
    of_legs.initial = params.plant.initial;
    foot_forces_of_legs = &Add<FootForcesOfLegs>("foot_forces", of_legs);
    Connect(state, foot_forces_of_legs->state);
    Connect(world.measured_torque, foot_forces_of_legs->torque);
    Connect(locomotion.ground, foot_forces_of_legs->ground);
    return foot_forces_of_legs->forces;
  }
  FootForceEstimateParams turned{.robot = params.plant.robot, .rate = params.foot_sensor.rate};
  turned.initial_q_WB = params.plant.initial.q_WB;
  foot_force_estimate = &Add<FootForceEstimate>("foot_force_estimate", turned);
  Connect(world.foot_forces, foot_force_estimate->shank);
  Connect(world.joints, foot_force_estimate->joints);
  Connect(state, foot_force_estimate->state);
  return foot_force_estimate->forces;
}

/// Adds ropes and returns the wrench of their measured tensions.
const OutputPort<WrenchEstimate>& QuadrupedWalk::AddRopes(const QuadrupedRopesParams& params,
                                                          const OutputPort<WrenchEstimate>& external) {
  tensions = &Add<RopeTensions>(
      "tensions", RopeTensionsParams{.robot = locomotion.whole_body.params.robot,
                                     .ropes = params.ropes,
                                     .friction = locomotion.whole_body.params.gains.qp.friction});
  winches = &Add<HeldLag<CableVector>>("winches",
                                       HeldLagParams<CableVector>{.time_constant = params.winch_lag,
                                                                  .initial = params.initial_tension,
                                                                  .rate = tensions->params.rate,
                                                                  .unit = "N",
                                                                  .elements = RopeElements(params.ropes)});
  ropes = &Add<Ropes>("ropes", RopesParams{params.ropes});
  Connect(state, tensions->state);
  Connect(locomotion.ground, tensions->ground);
  Connect(locomotion.schedule, tensions->schedule);
  Connect(locomotion.body, tensions->body);
  Connect(external, tensions->external);
  Connect(ropes->tension, tensions->tension);
  Connect(tensions->command, winches->u);
  Connect(winches->y, ropes->command);
  Connect(world.state, ropes->robot);
  Connect(ropes->force, world.pull);
  return tensions->wrench;
}

/// Returns the command of the walk, which is to stand after the loss of a rope.
const OutputPort<WalkCommand>& QuadrupedWalk::AddStop() {
  const Rate rate = tensions->params.rate;
  const std::vector<Rope>& all = tensions->params.ropes;
  auto& lost = Add<UnitDelay<CableVector>>(
      "lost_ropes",
      UnitDelayParams<CableVector>{.initial = CableVector::Zero(static_cast<Eigen::Index>(all.size())),
                                   .rate = rate,
                                   .elements = RopeElements(all)});
  Connect(tensions->lost, lost.u);
  return AddFunction("stop", Sampled{rate}, Uses(walk.command, lost.y),
                     [](const WalkCommand& planned, const CableVector& lost) {
                       return lost.isZero(0) ? planned : WalkCommand{.height = planned.height};
                     });
}

/// Adds the supervisor and returns `command`, which is to stand unless it lets the controller walk.
const OutputPort<WalkCommand>& QuadrupedWalk::AddDeployment(const DeploymentParams& params,
                                                            const OutputPort<WalkCommand>& command) {
  deployment = &Add<Deployment>("deployment", params);
  drives = &Add<JointDrives>("drives");
  heartbeat = &AddFunction({"heartbeat", "s"}, Sampled{params.rate}, Uses(time), [](double t) { return t; });
  Connect(locomotion.torque, deployment->torque);
  Connect(world.joints, deployment->joints);
  Connect(state, deployment->state);
  Connect(*heartbeat, deployment->heartbeat);
  Connect(deployment->command, drives->command);
  Connect(world.joints, drives->joints);
  Connect(drives->torque, world.torque);
  auto& walked = Add<UnitDelay<bool>>("walked", {.rate = params.rate});
  Connect(AddFunction("walks", Uses(deployment->status),
                      [](const DeploymentStatus& status) { return status.mode == DeploymentMode::kWalk; }),
          walked.u);
  return AddFunction("deployed", Sampled{params.rate}, Uses(command, walked.y),
                     [](const WalkCommand& planned, bool walks) {
                       return walks ? planned : WalkCommand{.height = planned.height};
                     });
}

/// The planners read `wrench` alone, the whole-body controller its sum with `known_wrench`. Therefore
/// `wrench` contains the slow part of the additions' wrench, and `known_wrench` the rest.
void QuadrupedWalk::ConnectWrenches(const QuadrupedWalkParams& params) {
  const Sampled sampled{locomotion.whole_body.params.rate};
  const auto sum = [](const WrenchEstimate& a, const WrenchEstimate& b) -> WrenchEstimate {
    return {a.force_W + b.force_W, a.torque_W + b.torque_W};
  };
  const OutputPort<WrenchEstimate>*wrench = &observer.wrench, *known = nullptr;
  const OutputPort<Vec<6>>* slow = nullptr;
  if (params.known_additions) {
    const auto lag = [&](const char* name, double time_constant) -> HeldLag<Vec<6>>& {
      return Add<HeldLag<Vec<6>>>(
          name, HeldLagParams<Vec<6>>{.time_constant = time_constant, .rate = sampled.rate});
    };
    const auto as_wrench = [](const Vec<6>& w) -> WrenchEstimate { return {w.head<3>(), w.tail<3>()}; };
    auto& added = AddFunction("added_wrench", Uses(world.added_wrench), [](const WrenchEstimate& wrench) {
      Vec<6> both;
      both << wrench.force_W, wrench.torque_W;
      return both;
    });
    known_additions = &lag("known_additions", params.additions_lag);
    auto& slow_additions = lag("slow_additions", params.additions_planning_lag);
    slow = &slow_additions.y;
    Connect(added, known_additions->u);
    Connect(known_additions->y, slow_additions.u);
    known = &AddFunction("known_wrench", sampled, Uses(known_additions->y), as_wrench);
    wrench = &AddFunction(
        "wrench", sampled, Uses(observer.wrench, *slow),
        [=](const WrenchEstimate& estimate, const Vec<6>& slow) { return sum(estimate, as_wrench(slow)); });
  }
  Connect(*wrench, locomotion.wrench);
  if (params.ropes) {
    const OutputPort<WrenchEstimate>& of_ropes = AddRopes(*params.ropes, *wrench);
    Connect(of_ropes, locomotion.steady_wrench);
    known = known == nullptr ? &of_ropes : &AddFunction("all_known", sampled, Uses(of_ropes, *known), sum);
  }
  if (known == nullptr) return;
  Connect(*known, observer.known_wrench);
  if (slow != nullptr)
    known = &AddFunction("fast_wrench", sampled, Uses(*known, *slow),
                         [](const WrenchEstimate& all, const Vec<6>& slow) -> WrenchEstimate {
                           return {all.force_W - slow.head<3>(), all.torque_W - slow.tail<3>()};
                         });
  Connect(*known, locomotion.known_wrench);
}

void QuadrupedWalk::ConnectObserver(const OutputPort<FootForces>& foot_forces) {
  Connect(state, observer.state);
  Connect(world.measured_torque, observer.torque);
  Connect(foot_forces, observer.foot_forces);
  auto& last_ground = Add<UnitDelay<GroundPlane>>(
      "last_ground", UnitDelayParams<GroundPlane>{.rate = locomotion.ground_estimator.params.rate});
  Connect(locomotion.ground, last_ground.u);
  Connect(last_ground.y, observer.ground);
  if (estimator != nullptr) Connect(last_ground.y, estimator->ground);
  Connect(estimator != nullptr ? estimator->inertial : world.inertial, observer.imu);
}

void QuadrupedWalk::ConnectEvaluation() {
  Connect(world.state, view.state);
  Connect(locomotion.body, view.body);
  Connect(observer.wrench, view.wrench);
  Connect(observer.leg_forces, view.leg_forces);
  Connect(world.state, errors.state);
  Connect(state, errors.told);
  Connect(world.ground_forces, errors.foot_forces);
  Connect(locomotion.schedule, errors.schedule);
  Connect(locomotion.body, errors.body);
  Connect(locomotion.feet, errors.feet);
  Connect(locomotion.plan, errors.plan);
  Connect(world.external_torque, errors.external_torque);
}

}  // namespace tenon
