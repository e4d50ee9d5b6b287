// The output of each block of LeggedLocomotion can be replaced by that of another block.

#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <gtest/gtest.h>

namespace tenon::legged_locomotion_test {

template <class T>
struct OverrideParams {
  std::function<T(const T&)> function;
};
/// A function of a signal, inserted behind a port.
template <class T>
class Override final : public LeafSystem<OverrideParams<T>> {
 public:
  using LeafSystem<OverrideParams<T>>::LeafSystem;
  InputPort<T> in{this, {"in"}};
  OutputPort<T> out{this, {"out"}, Uses(in), &Override::Calc};

 private:
  T Calc(const T& in) const { return this->params.function(in); }
};

/// A robot that trots on the spot, and the dynamics of its initial stance.
struct Loop {
  template <class T>
  void Insert(const OutputPort<T>& port, std::function<T(const T&)> function) {
    auto& block = builder.Add<Override<T>>("override", OverrideParams<T>{std::move(function)});
    builder.Insert(port, block.in, block.out);
  }

  QuadrupedDescription robot = test::DogBot();
  QuadrupedDynamics stance = [this] {
    QuadrupedDynamics dynamics;
    QuadrupedModel(robot).Calc(test::Standing(robot), &dynamics);
    return dynamics;
  }();
  DiagramBuilder builder;
  QuadrupedWorld& world = [this]() -> QuadrupedWorld& {
    QuadrupedWorldParams params;
    params.plant.robot = robot;
    params.plant.initial = test::Standing(robot);
    return builder.Add<QuadrupedWorld>("world", params);
  }();
  LeggedLocomotion& locomotion = builder.Add<LeggedLocomotion>("locomotion", MakeLocomotion(robot));
};

/// Figures of one second of trotting on the spot.
struct Trot {
  double lift = 0;    ///< largest height of a foot above its place [m]
  double height = 0;  ///< final height of the CoM above its initial one [m]
  double yaw = 0;     ///< final yaw of the trunk [rad]
};

/// Connects the loop after a change, and runs it.
Trot TrotWith(const std::function<void(Loop&)>& change) {
  Loop loop;
  auto& [robot, stance, builder, world, locomotion] = loop;
  auto& command = builder.AddFunction({"command"}, Uses(builder.time),
                                      [](double) { return WalkCommand{.gait = Gait::kTrot}; });
  builder.Connect(command, locomotion.command);
  builder.Connect(world.state, locomotion.state);
  builder.Connect(world.foot_forces, locomotion.foot_forces);
  builder.Connect(locomotion.torque, world.torque);
  change(loop);
  Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-2, .atol = 1e-5});
  const QuadrupedModel model(robot);
  QuadrupedDynamics now;
  Trot trot;
  for (int tick = 1; tick <= 200; ++tick) {
    EXPECT_FALSE(simulator.AdvanceTo(0.005 * tick).ended);
    model.Calc(simulator.context().Eval(world.state), &now);
    for (std::size_t leg = 0; leg < kNumLegs; ++leg)
      trot.lift = std::max(trot.lift, now.feet[leg].p_W[2] - stance.feet[leg].p_W[2]);
  }
  trot.height = now.com_W[2] - stance.com_W[2];
  const Eigen::Matrix3d R = simulator.context().Eval(world.state).R_WB();
  trot.yaw = std::atan2(R(1, 0), R(0, 0));
  return trot;
}

/// A change of the loop, and the figures that it leads to.
struct Change {
  const char* block;
  std::function<void(Loop&)> change;
  double lift = 0.05, height = 0, yaw = 0;
  double height_tolerance = 2e-3;
};

// Each replacement changes only its part of the motion.
TEST(LeggedLocomotionTest, EachBlockCanBeReplacedByAFunction) {
  const std::vector<Change> changes{
      {.block = "none", .change = [](Loop&) {}},
      {.block = "scheduler",  // all feet stand
       .change =
           [](Loop& loop) {
             loop.Insert<ContactSchedule>(loop.locomotion.scheduler.schedule,
                                          [](const auto&) { return ContactSchedule(); });
           },
       .lift = 0},
      {.block = "ground_estimator",  // ground that is 2 cm lower
       .change =
           [](Loop& loop) {
             loop.Insert<GroundPlane>(loop.locomotion.ground_estimator.ground, [](const auto&) {
               return GroundPlane{.p_W = {0, 0, -0.02}, .slope = {0, 0}};
             });
           },
       .height = -0.02},
      {.block = "com_planner",  // a CoM that is 2 cm lower
       .change =
           [](Loop& loop) {
             loop.Insert<BodyReference>(loop.locomotion.com_planner.reference,
                                        [com_W = loop.stance.com_W](const auto&) {
                                          return BodyReference{.com_W = com_W - Vec<3>(0, 0, 0.02)};
                                        });
           },
       .height = -0.02},
      {.block = "swing_planner",  // steps of half the height
       .change =
           [](Loop& loop) {
             loop.Insert<FeetReference>(loop.locomotion.swing_planner.feet,
                                        [start = loop.stance.feet](FeetReference feet) {
                                          for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
                                            FootReference& foot = feet.feet[leg];
                                            foot.p_W[2] = (foot.p_W[2] + start[leg].p_W[2]) / 2;
                                            foot.v_W[2] /= 2;
                                            foot.a_W[2] /= 2;
                                          }
                                          return feet;
                                        });
           },
       .lift = 0.025},
      {.block = "trunk_planner",  // a trunk that is turned to the left
       .change =
           [](Loop& loop) {
             loop.Insert<BodyReference>(loop.locomotion.trunk_planner->reference, [](BodyReference body) {
               body.q_WB = QuaternionProduct(QuaternionFromRotationVector(Vec<3>(0, 0, 0.1)), body.q_WB);
               return body;
             });
           },
       .yaw = 0.1},
      {.block =
           "whole_body",  // gravity compensation of the stance, and a joint PD controller, which is softer
       .change =
           [](Loop& loop) {
             const Vec<12> hold = loop.stance.gravity.tail<12>();
             const auto& torque =
                 loop.builder.AddFunction({"stand", "N m"}, Sampled{Hz(1000)}, Uses(loop.world.joints),
                                          [hold, stance = loop.robot.stance](const JointMotion& joints) {
                                            return Vec<12>(hold + 500 * (stance - joints.q) - 10 * joints.qd);
                                          });
             loop.builder.Disconnect(loop.world.torque);
             loop.builder.Connect(torque, loop.world.torque);
           },
       .lift = 0,
       .height_tolerance = 0.01}};
  for (const auto& [block, change, lift, height, yaw, height_tolerance] : changes) {
    const Trot trot = TrotWith(change);
    EXPECT_NEAR(trot.lift, lift, 3e-3) << block;
    EXPECT_NEAR(trot.height, height, height_tolerance) << block;
    EXPECT_NEAR(trot.yaw, yaw, 0.02) << block;
  }
}

}  // namespace tenon::legged_locomotion_test
