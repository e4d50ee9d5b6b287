#pragma once

#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

namespace tenon::test {

/// DogBot stands for half a second, then trots at 0.12 m/s along an arc, while a force of 20 N pulls at its
/// front left knee. The controller knows all but the force.
struct TrotLoop {
  TrotLoop() {
    const QuadrupedDescription robot = DogBot();
    QuadrupedWalkParams params = MakeQuadrupedWalk(robot);
    ExternalForce pull = PointOnLeg(robot, kFrontLeft, 0.5);
    pull.force_W << 20, 0, 0;
    params.world.pulses.push_back({pull, 0, 60});
    params.observer.kind = ObserverKind::kNone;
    params.walk.segments = {{.duration = 0.5},
                            {.gait = Gait::kTrot, .forward = 0.12, .yaw_rate = 0.05, .duration = 60}};
    DiagramBuilder builder;
    loop = &builder.Add<QuadrupedWalk>("loop", params);
    diagram = builder.Build();
  }
  /// Tolerances of the walk; `plant` is the path of the plant.
  static SimulatorOptions Options(const std::string& plant = "loop.world.plant") {
    return {.order = 2,
            .rtol = 1e-2,
            .atol = 1e-4,
            .state_atol = {{plant + ".motion.v_W", 1e-2},
                           {plant + ".motion.w_W", 1e-2},
                           {plant + ".motion.qd", 1e-2},
                           {plant + ".bristles", 1e-5}}};
  }

  QuadrupedWalk* loop;
  std::shared_ptr<const Diagram> diagram;
};

/// The signals of the controller at one tick.
struct TrotTick {
  WalkCommand command;
  FootForces foot_forces;
  LeggedState state;
  ContactSchedule schedule;
  GroundPlane ground;
  BodyReference body;
  PlanarPath path;
  FeetReference feet;
  WholeBodyPlan plan;
  Vec<12> torque;
  ExternalForces external;
};

/// The first `seconds` of the walk at 1 kHz; after two seconds it has settled.
inline std::vector<TrotTick> RecordTrot(const TrotLoop& trot, double seconds) {
  Simulator simulator(*trot.diagram, TrotLoop::Options());
  std::vector<TrotTick> ticks;
  Context& context = simulator.context();
  const LeggedLocomotion& locomotion = trot.loop->locomotion;
  const QuadrupedWorld& world = trot.loop->world;
  for (int n = 0; n < std::lround(1000 * seconds); ++n) {
    const RunStatus status = simulator.AdvanceTo(n / 1000.0);
    if (status.ended) throw RunError("the trot ended: " + status.reason);
    TrotTick& tick = ticks.emplace_back();
    tick.command = context.Eval(trot.loop->walk.command);
    tick.foot_forces = context.Eval(world.foot_sensor.measured);
    tick.state = context.Eval(world.plant.state);
    tick.schedule = context.Eval(locomotion.scheduler.schedule);
    tick.ground = context.Eval(locomotion.ground_estimator.ground);
    tick.body = context.Eval(locomotion.com_planner.reference);
    tick.path = context.Eval(locomotion.com_planner.path);
    tick.feet = context.Eval(locomotion.swing_planner.feet);
    tick.plan = context.Eval(locomotion.whole_body.plan);
    tick.torque = context.Eval(locomotion.whole_body.torque);
    tick.external = context.Eval(world.disturbances.forces);
  }
  return ticks;
}

/// The task of the whole-body controller at one tick.
struct TrotTask {
  QuadrupedDynamics dynamics;
  WholeBodyTask task;
};
inline TrotTask MakeTask(const WholeBodyController& controller, const TrotTick& tick) {
  TrotTask made;
  const WholeBodyGains& gains = controller.params.gains;
  QuadrupedDynamics of_model;
  QuadrupedModel(controller.params.robot).Calc(tick.state, &of_model);
  controller.CalcDynamics(of_model, tick.schedule, tick.ground, gains, &made.dynamics);
  made.task = controller.MakeTask(made.dynamics, tick.state, tick.schedule, tick.body, tick.feet, {}, {},
                                  tick.ground, gains);
  return made;
}

}  // namespace tenon::test
