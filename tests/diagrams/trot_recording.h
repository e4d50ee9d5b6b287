#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tenon/controllers/com_planner.h"
#include "tenon/controllers/foot_scheduler.h"
#include "tenon/controllers/swing_planner.h"
#include "tenon/controllers/walk_schedule.h"
#include "tenon/controllers/whole_body_controller.h"
#include "tenon/plants/quadruped_plant.h"
#include "tenon/systems/diagram_builder.h"
#include "tenon/systems/primitives/constant.h"
#include "tenon/systems/simulator.h"
#include "tenon/systems/yaml.h"
#include "tenon/tests/plants/quadruped_test_robot.h"

namespace tenon::test {

/// DogBot stands for half a second, then trots at 0.12 m/s along an arc, with perfect knowledge.
struct TrotLoop {
  TrotLoop() {
    QuadrupedPlantParams plant_params;
    plant_params.robot = DogBot();
    plant_params.initial = Standing(plant_params.robot);
    const QuadrupedDescription& robot = plant_params.robot;
    DiagramBuilder builder;
    plant = &builder.Add<QuadrupedPlant>("plant", plant_params);
    WalkScheduleParams walk_params;
    walk_params.segments.resize(2);
    walk_params.segments[0].duration = 0.5;
    walk_params.segments[1].gait = Gait::kTrot;
    walk_params.segments[1].forward = 0.12;
    walk_params.segments[1].yaw_rate = 0.05;
    walk_params.segments[1].duration = 60;
    walk = &builder.Add<WalkSchedule>("walk", walk_params);
    scheduler = &builder.Add<FootScheduler>(
        "scheduler", YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml").Read<FootSchedulerParams>());
    ComPlannerParams com_params;
    com_params.robot = robot;
    com_planner = &builder.Add<ComPlanner>("com_planner", com_params);
    SwingPlannerParams swing_params;
    swing_params.robot = robot;
    swing_planner = &builder.Add<SwingPlanner>("swing_planner", swing_params);
    WholeBodyParams wbc_params;
    wbc_params.robot = robot;
    wbc = &builder.Add<WholeBodyController>("wbc", wbc_params);
    auto& wrench = builder.Add<ConstantSource<WrenchEstimate>>("wrench");
    auto& leg_forces = builder.Add<ConstantSource<LegForceEstimate>>("leg_forces");
    builder.Connect(walk->command, scheduler->command);
    builder.Connect(walk->command, com_planner->command);
    builder.Connect(plant->foot_forces, scheduler->foot_forces);
    builder.Connect(plant->state, com_planner->state);
    builder.Connect(plant->state, swing_planner->state);
    builder.Connect(plant->state, wbc->state);
    builder.Connect(scheduler->schedule, com_planner->schedule);
    builder.Connect(scheduler->schedule, swing_planner->schedule);
    builder.Connect(scheduler->schedule, wbc->schedule);
    builder.Connect(com_planner->path, swing_planner->path);
    builder.Connect(com_planner->reference, swing_planner->body);
    builder.Connect(com_planner->reference, wbc->body);
    builder.Connect(swing_planner->feet, wbc->feet);
    builder.Connect(wrench.y, wbc->wrench);
    builder.Connect(leg_forces.y, wbc->leg_forces);
    builder.Connect(wbc->torque, plant->torque);
    diagram = builder.Build();
  }
  /// The tolerances that QuadrupedPlant recommends, with order 2.
  static SimulatorOptions Options() {
    return {.order = 2,
            .rtol = 1e-3,
            .atol = 1e-5,
            .state_atol = {{"plant.motion.v_W", 1e-3},
                           {"plant.motion.w_W", 1e-3},
                           {"plant.motion.qd", 1e-3},
                           {"plant.bristles", 1e-6}}};
  }

  QuadrupedPlant* plant;
  WalkSchedule* walk;
  FootScheduler* scheduler;
  ComPlanner* com_planner;
  SwingPlanner* swing_planner;
  WholeBodyController* wbc;
  std::unique_ptr<Diagram> diagram;
};

/// What the blocks read at one tick of the walk.
struct TrotTick {
  WalkCommand command;
  FootForces foot_forces;
  LeggedState state;
  ContactSchedule schedule;
  BodyReference body;
  PlanarPath path;
  FeetReference feet;
  WrenchEstimate wrench;
  LegForceEstimate leg_forces;
  Vec<12> torque;
};

/// The first `seconds` of the walk at 1 kHz; after two seconds it has settled.
inline std::vector<TrotTick> RecordTrot(const TrotLoop& loop, double seconds) {
  Simulator simulator(*loop.diagram, TrotLoop::Options());
  std::vector<TrotTick> ticks;
  Context& context = simulator.context();
  for (int n = 0; n < std::lround(1000 * seconds); ++n) {
    simulator.AdvanceTo(n / 1000.0);
    TrotTick& tick = ticks.emplace_back();
    tick.command = context.Eval(loop.walk->command);
    tick.foot_forces = context.Eval(loop.plant->foot_forces);
    tick.state = context.Eval(loop.plant->state);
    tick.schedule = context.Eval(loop.scheduler->schedule);
    tick.body = context.Eval(loop.com_planner->reference);
    tick.path = context.Eval(loop.com_planner->path);
    tick.feet = context.Eval(loop.swing_planner->feet);
    tick.torque = context.Eval(loop.wbc->torque);
  }
  return ticks;
}

}  // namespace tenon::test
