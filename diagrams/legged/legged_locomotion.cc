#include <tenon/controllers/legged/planning/thesis_planner.h>
#include <tenon/controllers/legged/planning/trajectory_planner.h>
#include <tenon/diagrams/legged/legged_locomotion.h>

namespace tenon {

LeggedLocomotion::LeggedLocomotion(const LeggedLocomotionParams& params)
    : step_timing(Add<StepTimingAdapter>("step_timing", params.step_timing)),
      scheduler(Add<FootScheduler>("scheduler", params.scheduler)),
      ground_estimator(Add<GroundEstimator>("ground_estimator", params.ground)),
      com_planner(Add<ComPlanner>("com_planner", params.com_planner)),
      swing_planner(Add<SwingPlanner>("swing_planner", params.swing_planner)),
      whole_body(Add<WholeBodyController>("whole_body", params.whole_body)) {
  if (params.com_planner.reference == ComReference::kThesis ||
      params.com_planner.reference == ComReference::kHeuristic) {
    auto& planner = Replace<ThesisPlanner>(com_planner, params.com_planner);
    Connect(state, planner.state);
    Connect(foot_forces, planner.foot_forces);
    Connect(wrench, planner.wrench);
  }
  if (params.pace) {
    pacer = &Add<Pacer>("pacer", PacerParams{.robot = params.whole_body.robot,
                                             .gaits = params.scheduler.gaits,
                                             .pace = *params.pace,
                                             .rate = params.scheduler.rate});
    Connect(command, pacer->command);
    Connect(pacer->paced, scheduler.command);
    Connect(pacer->timing, scheduler.timing);
    Connect(pacer->paced, com_planner.command);
  } else {
    Connect(command, scheduler.command);
    Connect(command, com_planner.command);
  }
  Connect(foot_forces, scheduler.foot_forces);
  Connect(state, step_timing.state);
  const bool optimised = params.com_planner.reference == ComReference::kTrajectory;
  const OutputPort<BodyReference>& reference = optimised ? AddTrajectory(params) : com_planner.reference;
  Connect(reference, step_timing.body);
  if (pacer == nullptr) {  // a fast trot tilts the trunk at each step
    Connect(step_timing.clock_rate, scheduler.clock_rate);
    Connect(step_timing.clock_rate, swing_planner.clock_rate);
  }

  Connect(state, ground_estimator.state);
  Connect(scheduler.schedule, ground_estimator.schedule);

  const OutputPort<GroundPlane>& planned_ground = params.mapped ? AddMap(params) : ground_estimator.ground;
  Connect(scheduler.schedule, com_planner.schedule);
  // The plane that fits a map best sinks into a gap.
  Connect(optimised ? ground_estimator.ground : planned_ground, com_planner.ground);

  Connect(scheduler.schedule, swing_planner.schedule);
  Connect(com_planner.path, swing_planner.path);
  Connect(reference, swing_planner.body);
  Connect(state, swing_planner.state);
  Connect(planned_ground, swing_planner.ground);
  Connect(foot_forces, swing_planner.foot_forces);
  Connect(wrench, swing_planner.wrench);

  Connect(state, whole_body.state);
  Connect(scheduler.schedule, whole_body.schedule);
  if (params.mpc) {
    AddMpc(params, planned_ground);
  } else {
    trunk_planner = &Add<TrunkPlanner>("trunk_planner", params.trunk_planner);
    Connect(reference, trunk_planner->body);
    Connect(scheduler.schedule, trunk_planner->schedule);
    Connect(state, trunk_planner->state);
    Connect(wrench, trunk_planner->wrench);
    Connect(trunk_planner->reference, whole_body.body);
  }
  Connect(swing_planner.feet, whole_body.feet);
  Connect(wrench, whole_body.wrench);
  Connect(steady_wrench, swing_planner.known_wrench);
  Connect(known_wrench, whole_body.known_wrench);
  Connect(leg_forces, whole_body.leg_forces);
  Connect(ground_estimator.ground, whole_body.ground);

  Connect(whole_body.torque, torque);
  Connect(scheduler.schedule, schedule);
  Connect(reference, body);
  Connect(swing_planner.feet, feet);
  Connect(whole_body.plan, plan);
  Connect(ground_estimator.ground, ground);
}

const OutputPort<GroundPlane>& LeggedLocomotion::AddMap(const LeggedLocomotionParams& params) {
  mapped_ground = &Add<MappedGround>("mapped_ground", MappedGroundParams{.robot = params.whole_body.robot});
  Connect(map, mapped_ground->map);
  Connect(state, mapped_ground->state);
  Connect(map, swing_planner.map);
  return mapped_ground->ground;
}

const OutputPort<BodyReference>& LeggedLocomotion::AddTrajectory(const LeggedLocomotionParams& params) {
  Demand(!params.mpc, "trajectory and mpc both choose the footholds: use one of them");
  TrajectoryPlannerParams of_planner{.robot = params.whole_body.robot};
  of_planner.trajectory = params.com_planner.trajectory;
  of_planner.footing = params.swing_planner.step.footing;
  of_planner.friction = params.whole_body.gains.qp.friction;
  trajectory_planner = &Add<TrajectoryPlanner>("trajectory_planner", of_planner);
  Connect(scheduler.schedule, trajectory_planner->schedule);
  Connect(com_planner.reference, trajectory_planner->body);
  Connect(com_planner.path, trajectory_planner->path);
  Connect(state, trajectory_planner->state);
  Connect(ground_estimator.ground, trajectory_planner->ground);
  if (params.mapped) Connect(map, trajectory_planner->map);
  Connect(trajectory_planner->footholds, swing_planner.planned);
  return trajectory_planner->reference;
}

void LeggedLocomotion::AddMpc(const LeggedLocomotionParams& params,
                              const OutputPort<GroundPlane>& planned_ground) {
  CentroidalMpcParams of_mpc{.robot = params.whole_body.robot, .mpc = *params.mpc};
  of_mpc.friction = params.whole_body.gains.qp.friction;
  of_mpc.retarget_phase = params.swing_planner.step.retarget_phase;
  if (params.calculation.any()) {
    auto& slow =
        Add<Slow<CentroidalMpc, &CentroidalMpc::plan>>("mpc", {.block = of_mpc, .slow = params.calculation});
    mpc = &slow;
    mpc_age = &slow.age;
  } else {
    mpc = &Add<CentroidalMpc>("mpc", of_mpc);
  }
  Connect(com_planner.reference, mpc->body);
  Connect(com_planner.path, mpc->path);
  Connect(scheduler.schedule, mpc->schedule);
  Connect(state, mpc->state);
  Connect(planned_ground, mpc->ground);
  Connect(wrench, mpc->wrench);
  Connect(known_wrench, mpc->known_wrench);
  Connect(mpc->reference, whole_body.body);
  Connect(mpc->footholds, swing_planner.planned);
}

}  // namespace tenon
