// Each block of LeggedLocomotion can be replaced by another one, for example by a function.

#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenon::legged_locomotion_test {
namespace {

enum class Replaced {
  kNone,
  kScheduler,
  kGroundEstimator,
  kComPlanner,
  kSwingPlanner,
  kTrunkPlanner,
  kWholeBody
};

/// Figures of one second of trotting on the spot.
struct Trot {
  double lift = 0;    ///< largest height of a foot above its place [m]
  double height = 0;  ///< final height of the CoM above its initial one [m]
  double yaw = 0;     ///< final yaw of the trunk [rad]
  LeggedState end;
};

/// A step on the spot, 3 cm high, that ends 1 cm below the ground, so that the foot presses on it.
FootReference Step(const Vec<3>& place, const LegContact& leg, double swing) {
  FootReference foot{place, Vec<3>::Zero(), Vec<3>::Zero()};
  if (leg.stance()) return foot;
  const double height = 0.03, rate = 2 * std::numbers::pi / swing, angle = 2 * std::numbers::pi * leg.phase;
  foot.p_W[2] += height / 2 * (1 - std::cos(angle)) - 0.01 * leg.phase;
  foot.v_W[2] = height / 2 * rate * std::sin(angle) - 0.01 / swing;
  foot.a_W[2] = height / 2 * rate * rate * std::cos(angle);
  return foot;
}

Trot Observe(const QuadrupedDescription& robot, const QuadrupedWorld& world, const Diagram& diagram) {
  Simulator simulator(diagram, {.order = 2, .rtol = 1e-2, .atol = 1e-5});
  const QuadrupedModel model(robot);
  QuadrupedDynamics first, now;
  model.Calc(simulator.context().Eval(world.state), &first);
  Trot trot;
  for (int tick = 1; tick <= 200; ++tick) {
    EXPECT_FALSE(simulator.AdvanceTo(0.005 * tick).ended);
    model.Calc(simulator.context().Eval(world.state), &now);
    for (std::size_t leg = 0; leg < kNumLegs; ++leg)
      trot.lift = std::max(trot.lift, now.feet[leg].p_W[2] - first.feet[leg].p_W[2]);
  }
  trot.end = simulator.context().Eval(world.state);
  trot.height = now.com_W[2] - first.com_W[2];
  const Eigen::Matrix3d R = trot.end.R_WB();
  trot.yaw = std::atan2(R(1, 0), R(0, 0));
  return trot;
}

QuadrupedWorldParams Outside(const QuadrupedDescription& robot) {
  QuadrupedWorldParams outside;
  outside.plant.robot = robot;
  outside.plant.initial = test::Standing(robot);
  return outside;
}

/// The inputs of the locomotion except those from the robot.
struct Given {
  const OutputPort<WalkCommand>& command;
  const OutputPort<WrenchEstimate>& wrench;
  const OutputPort<LegForceEstimate>& leg_forces;
};

/// A trot on the spot with an estimated force `felt` [N] on the trunk and a hundredth of it [N m] on each
/// joint.
Given AddGiven(DiagramBuilder& builder, const Vec<3>& felt) {
  return {builder.AddFunction({"command"}, Uses(builder.time),
                              [](double) { return WalkCommand{.gait = Gait::kTrot}; }),
          builder.AddFunction({"wrench"}, Uses(builder.time),
                              [=](double) { return WrenchEstimate{.force_W = felt}; }),
          builder.AddFunction({"leg_forces"}, Uses(builder.time), [=](double) {
            return LegForceEstimate{.joint_torque = Vec<12>::Constant(0.01 * felt.norm()), .foot_force = {}};
          })};
}

/// The controller wired by hand, with one block replaced by a function.
Trot TrotWith(Replaced replaced, const Vec<3>& felt = Vec<3>::Zero()) {
  const QuadrupedDescription robot = test::DogBot();
  const LeggedLocomotionParams params = MakeLocomotion(robot);
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot).Calc(test::Standing(robot), &dynamics);

  DiagramBuilder builder;
  auto& world = builder.Add<QuadrupedWorld>("world", Outside(robot));
  const auto [command, wrench, leg_forces] = AddGiven(builder, felt);

  const OutputPort<ContactSchedule>* schedule = nullptr;
  if (replaced == Replaced::kScheduler) {  // ignores the command: all feet stand
    schedule =
        &builder.AddFunction({"scheduler"}, Uses(builder.time), [](double) { return ContactSchedule(); });
  } else {
    auto& scheduler = builder.Add<FootScheduler>("scheduler", params.scheduler);
    builder.Connect(command, scheduler.command);
    builder.Connect(world.foot_forces, scheduler.foot_forces);
    schedule = &scheduler.schedule;
  }

  const OutputPort<GroundPlane>* ground = nullptr;
  if (replaced == Replaced::kGroundEstimator) {  // ground that is 2 cm lower
    ground = &builder.AddFunction({"ground_estimator"}, Uses(builder.time), [](double) {
      return GroundPlane{.p_W = {0, 0, -0.02}, .slope = {0, 0}};
    });
  } else {
    auto& estimator = builder.Add<GroundEstimator>("ground_estimator", params.ground);
    builder.Connect(world.state, estimator.state);
    builder.Connect(*schedule, estimator.schedule);
    ground = &estimator.ground;
  }

  const OutputPort<BodyReference>* body = nullptr;
  const OutputPort<PlanarPath>* path = nullptr;
  if (replaced == Replaced::kComPlanner) {  // 2 cm lower
    body = &builder.AddFunction({"com_planner"}, Uses(builder.time), [x = dynamics.com_W](double) {
      BodyReference reference;
      reference.com_W = x - Vec<3>(0, 0, 0.02);
      return reference;
    });
    path = &builder.AddFunction({"path"}, Uses(builder.time), [x = dynamics.com_W](double) {
      return PlanarPath{.position_W = x.head<2>()};
    });
  } else {
    auto& planner = builder.Add<ComPlanner>("com_planner", params.com_planner);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(command, planner.command);
    builder.Connect(*ground, planner.ground);
    body = &planner.reference;
    path = &planner.path;
  }

  const OutputPort<FeetReference>* feet = nullptr;
  if (replaced == Replaced::kSwingPlanner) {  // steps half as high
    feet = &builder.AddFunction(
        {"swing_planner"}, Uses(*schedule), [start = dynamics.feet](const ContactSchedule& schedule) {
          FeetReference reference;
          for (std::size_t leg = 0; leg < kNumLegs; ++leg)
            reference.feet[leg] = Step(start[leg].p_W, schedule.legs[leg], schedule.timing.swing);
          return reference;
        });
  } else {
    auto& planner = builder.Add<SwingPlanner>("swing_planner", params.swing_planner);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(*path, planner.path);
    builder.Connect(*body, planner.body);
    builder.Connect(world.state, planner.state);
    builder.Connect(*ground, planner.ground);
    builder.Connect(world.foot_forces, planner.foot_forces);
    builder.Connect(wrench, planner.wrench);
    feet = &planner.feet;
  }

  if (replaced == Replaced::kTrunkPlanner) {  // turned to the left
    body = &builder.AddFunction({"trunk_planner"}, Uses(*body), [](const BodyReference& reference) {
      BodyReference turned = reference;
      turned.q_WB = QuaternionProduct(QuaternionFromRotationVector(Vec<3>(0, 0, 0.1)), reference.q_WB);
      return turned;
    });
  } else {
    auto& planner = builder.Add<TrunkPlanner>("trunk_planner", params.trunk_planner);
    builder.Connect(*body, planner.body);
    builder.Connect(*schedule, planner.schedule);
    builder.Connect(world.state, planner.state);
    builder.Connect(wrench, planner.wrench);
    body = &planner.reference;
  }

  if (replaced == Replaced::kWholeBody) {
    // Gravity compensation of the nominal stance, and a joint PD controller.
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
    builder.Connect(*ground, whole_body.ground);
    builder.Connect(whole_body.torque, world.torque);
  }
  return Observe(robot, world, *builder.Build());
}

// Each replacement changes only its part of the motion.
TEST(LeggedLocomotionTest, EachBlockCanBeAFunction) {
  for (const Replaced replaced :
       {Replaced::kNone, Replaced::kScheduler, Replaced::kGroundEstimator, Replaced::kComPlanner,
        Replaced::kSwingPlanner, Replaced::kTrunkPlanner, Replaced::kWholeBody}) {
    const Trot trot = TrotWith(replaced);
    const bool stands = replaced == Replaced::kScheduler || replaced == Replaced::kWholeBody;
    const double lift = stands ? 0 : replaced == Replaced::kSwingPlanner ? 0.025 : 0.05;
    EXPECT_NEAR(trot.lift, lift, 3e-3) << static_cast<int>(replaced);
    const bool lower = replaced == Replaced::kComPlanner || replaced == Replaced::kGroundEstimator;
    EXPECT_NEAR(trot.height, lower ? -0.02 : 0,
                replaced == Replaced::kWholeBody ? 0.01 : 2e-3)  // a PD is soft
        << static_cast<int>(replaced);
    EXPECT_NEAR(trot.yaw, replaced == Replaced::kTrunkPlanner ? 0.1 : 0, 0.02) << static_cast<int>(replaced);
  }
}

// Wired by hand, the six blocks give the numbers of the nested diagram, bit for bit, with disturbances too.
TEST(LeggedLocomotionTest, IsItsSixBlocks) {
  const QuadrupedDescription robot = test::DogBot();
  const Vec<3> felt(5, 60, -10);  // large enough to move the footholds
  DiagramBuilder builder;
  auto& world = builder.Add<QuadrupedWorld>("world", Outside(robot));
  auto& locomotion = builder.Add<LeggedLocomotion>("locomotion", MakeLocomotion(robot));
  const auto [command, wrench, leg_forces] = AddGiven(builder, felt);
  builder.Connect(command, locomotion.command);
  builder.Connect(world.state, locomotion.state);
  builder.Connect(world.foot_forces, locomotion.foot_forces);
  builder.Connect(wrench, locomotion.wrench);
  builder.Connect(leg_forces, locomotion.leg_forces);
  builder.Connect(locomotion.torque, world.torque);
  const LeggedState nested = Observe(robot, world, *builder.Build()).end;
  const LeggedState wired = TrotWith(Replaced::kNone, felt).end;
  EXPECT_EQ(nested.p_WB, wired.p_WB);
  EXPECT_EQ(nested.q, wired.q);
}

}  // namespace
}  // namespace tenon::legged_locomotion_test
