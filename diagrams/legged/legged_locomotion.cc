#include <tenon/diagrams/legged/legged_locomotion.h>

namespace tenon {

LeggedLocomotion::LeggedLocomotion(const LeggedLocomotionParams& params)
    : scheduler(Add<FootScheduler>("scheduler", params.scheduler)),
      com_planner(Add<ComPlanner>("com_planner", params.com_planner)),
      swing_planner(Add<SwingPlanner>("swing_planner", params.swing_planner)),
      trunk_planner(Add<TrunkPlanner>("trunk_planner", params.trunk_planner)),
      whole_body(Add<WholeBodyController>("whole_body", params.whole_body)) {
  Connect(command, scheduler.command);
  Connect(foot_forces, scheduler.foot_forces);

  Connect(scheduler.schedule, com_planner.schedule);
  Connect(command, com_planner.command);
  Connect(state, com_planner.state);

  Connect(scheduler.schedule, swing_planner.schedule);
  Connect(com_planner.path, swing_planner.path);
  Connect(com_planner.reference, swing_planner.body);
  Connect(state, swing_planner.state);
  Connect(wrench, swing_planner.wrench);

  Connect(state, whole_body.state);
  Connect(scheduler.schedule, whole_body.schedule);
  Connect(com_planner.reference, trunk_planner.body);
  Connect(scheduler.schedule, trunk_planner.schedule);
  Connect(state, trunk_planner.state);
  Connect(wrench, trunk_planner.wrench);
  Connect(trunk_planner.reference, whole_body.body);
  Connect(swing_planner.feet, whole_body.feet);
  Connect(wrench, whole_body.wrench);
  Connect(leg_forces, whole_body.leg_forces);

  Connect(whole_body.torque, torque);
  Connect(scheduler.schedule, schedule);
  Connect(com_planner.reference, body);
  Connect(swing_planner.feet, feet);
  Connect(whole_body.plan, plan);
}

}  // namespace tenon
