// The blocks of LeggedLocomotion meet at ports alone: each can be another one, a function even.

#include <tenon/diagrams/legged/legged_locomotion.h>

#include <gtest/gtest.h>

#include <tenon/controllers/legged/profile/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

namespace tenon {
namespace {

enum class Replaced { kNone, kScheduler, kComPlanner, kSwingPlanner, kTrunkPlanner, kWholeBody };

/// A robot that stands, its controller wired by hand, with one block as a function; where its trunk is after
/// half a second.
Vec<3> Stand(Replaced replaced) {
  const QuadrupedDescription robot = test::DogBot();
  const LeggedLocomotionParams params = MakeLocomotion(robot);
  QuadrupedWorldParams outside;
  outside.plant.robot = robot;
  outside.plant.initial = test::Standing(robot);
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot).Calc(outside.plant.initial, &dynamics);

  DiagramBuilder builder;
  auto& world = builder.Add<QuadrupedWorld>("world", outside);
  const auto& command =
      builder.AddFunction({"command"}, Uses(builder.time), [](double) { return WalkCommand(); });
  const auto& wrench =
      builder.AddFunction({"wrench"}, Uses(builder.time), [](double) { return WrenchEstimate(); });
  const auto& leg_forces =
      builder.AddFunction({"leg_forces"}, Uses(builder.time), [](double) { return LegForceEstimate(); });

  const OutputPort<ContactSchedule>* schedule = nullptr;
  if (replaced == Replaced::kScheduler) {
    schedule =
        &builder.AddFunction({"scheduler"}, Uses(builder.time), [](double) { return ContactSchedule(); });
  } else {
    auto& scheduler = builder.Add<FootScheduler>("scheduler", params.scheduler);
    builder.Connect(command, scheduler.command);
    builder.Connect(world.foot_forces, scheduler.foot_forces);
    schedule = &scheduler.schedule;
  }

  const OutputPort<BodyReference>* body = nullptr;
  const OutputPort<PlanarPath>* path = nullptr;
  if (replaced == Replaced::kComPlanner) {
    body = &builder.AddFunction({"com_planner"}, Uses(builder.time), [x = dynamics.com_W](double) {
      BodyReference reference;
      reference.com_W = x;
      return reference;
    });
    path = &builder.AddFunction({"path"}, Uses(builder.time), [](double) { return PlanarPath(); });
  } else {
    auto& planner = builder.Add<ComPlanner>("com_planner", params.com_planner);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(command, planner.command);
    builder.Connect(world.state, planner.state);
    body = &planner.reference;
    path = &planner.path;
  }

  const OutputPort<FeetReference>* feet = nullptr;
  if (replaced == Replaced::kSwingPlanner) {
    feet =
        &builder.AddFunction({"swing_planner"}, Uses(builder.time), [](double) { return FeetReference(); });
  } else {
    auto& planner = builder.Add<SwingPlanner>("swing_planner", params.swing_planner);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(*path, planner.path);
    builder.Connect(*body, planner.body);
    builder.Connect(world.state, planner.state);
    builder.Connect(wrench, planner.wrench);
    feet = &planner.feet;
  }

  if (replaced != Replaced::kTrunkPlanner) {  // whose function is to pass on what it is given
    auto& planner = builder.Add<TrunkPlanner>("trunk_planner", params.trunk_planner);
    builder.Connect(*body, planner.body);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(world.state, planner.state);
    builder.Connect(wrench, planner.wrench);
    body = &planner.reference;
  }

  if (replaced == Replaced::kWholeBody) {
    // The feet carry the weight of the nominal stance, and a joint PD the rest.
    const Vec<12> hold = dynamics.gravity.tail<12>();
    const auto& torque =
        builder.AddFunction({"whole_body", "N m"}, Sampled{Hz(1000)}, Uses(world.joints),
                            [hold, stance = robot.stance](const JointMotion& joints) {
                              return Vec<12>(hold + 500 * (stance - joints.q) - 10 * joints.qd);
                            });
    builder.Connect(torque, world.torque);
  } else {
    auto& whole_body = builder.Add<WholeBodyController>("whole_body", params.whole_body);
    builder.Connect(world.state, whole_body.state);
    builder.Connect(*schedule, whole_body.schedule);
    builder.Connect(*body, whole_body.body);
    builder.Connect(*feet, whole_body.feet);
    builder.Connect(wrench, whole_body.wrench);
    builder.Connect(leg_forces, whole_body.leg_forces);
    builder.Connect(whole_body.torque, world.torque);
  }

  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 2, .rtol = 1e-2, .atol = 1e-5});
  EXPECT_FALSE(simulator.AdvanceTo(0.5).ended);
  return simulator.context().Eval(world.state).p_WB;
}

TEST(LeggedLocomotionTest, EachBlockCanBeAFunction) {
  const Vec<3> standing = Stand(Replaced::kNone);
  for (const Replaced replaced : {Replaced::kScheduler, Replaced::kComPlanner, Replaced::kSwingPlanner,
                                  Replaced::kTrunkPlanner, Replaced::kWholeBody}) {
    const double tolerance = replaced == Replaced::kWholeBody ? 0.02 : 2e-3;  // a PD is soft
    EXPECT_LT((Stand(replaced) - standing).norm(), tolerance) << static_cast<int>(replaced);
  }
}

// The nested diagram is those five blocks and nothing else: wired by hand they do the same, bit for bit.
TEST(LeggedLocomotionTest, IsItsFiveBlocks) {
  const QuadrupedDescription robot = test::DogBot();
  QuadrupedWorldParams outside;
  outside.plant.robot = robot;
  outside.plant.initial = test::Standing(robot);
  DiagramBuilder builder;
  auto& world = builder.Add<QuadrupedWorld>("world", outside);
  auto& locomotion = builder.Add<LeggedLocomotion>("locomotion", MakeLocomotion(robot));
  const auto& command =
      builder.AddFunction({"command"}, Uses(builder.time), [](double) { return WalkCommand(); });
  builder.Connect(command, locomotion.command);
  builder.Connect(world.state, locomotion.state);
  builder.Connect(world.foot_forces, locomotion.foot_forces);
  builder.Connect(locomotion.torque, world.torque);
  const auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 2, .rtol = 1e-2, .atol = 1e-5});
  simulator.RunTo(0.5);
  EXPECT_EQ(simulator.context().Eval(world.state).p_WB, Stand(Replaced::kNone));
}

}  // namespace
}  // namespace tenon
