#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/matchers.h>

#include <gmock/gmock.h>

namespace tenon::quadruped_stand_test {
namespace {

using test::A1;
using test::DogBot;

QuadrupedStandParams Params(const QuadrupedDescription& robot) {
  QuadrupedStandParams params;
  params.world.plant.robot = robot;
  params.world.plant.initial = test::Standing(robot);
  params.pd = {.robot = robot, .stiffness = 500, .damping = 10};
  params.world.min_height = 0.5 * robot.StanceHeight();
  return params;
}

/// The loop in a diagram of its own, with the tolerances that QuadrupedPlant recommends.
struct Cell {
  explicit Cell(const QuadrupedStandParams& params)
      : loop(builder.Add<QuadrupedStand>("loop", params)),
        diagram(builder.Build()),
        simulator(*diagram, {.order = 2,
                             .rtol = 1e-2,
                             .atol = 1e-4,
                             .state_atol = {{"loop.world.plant.motion.v_W", 1e-2},
                                            {"loop.world.plant.motion.w_W", 1e-2},
                                            {"loop.world.plant.motion.qd", 1e-2},
                                            {"loop.world.plant.bristles", 1e-6}}}) {}
  template <class S>
  const typename S::Value& operator[](const S& source) {
    return simulator.context().Eval(source);
  }
  DiagramBuilder builder;
  QuadrupedStand& loop;
  std::shared_ptr<const Diagram> diagram;
  Simulator simulator;
};

// With the feed-forward of the stance nothing is left for the PD: the joints stay where they should be, but
// for the sinking of the feet. Without it the weight bends them by tau / K_p.
TEST(QuadrupedStandTest, GravityCompensationHoldsTheStance) {
  for (const QuadrupedDescription& robot : {DogBot(), A1()}) {
    QuadrupedStandParams params = Params(robot);
    Cell with(params);
    EXPECT_FALSE(with.simulator.AdvanceTo(2).ended);
    const double friction = robot.drive.friction / 500;
    EXPECT_THAT(with[with.loop.world.state].q, IsNear(robot.stance, friction + 5e-4)) << robot.name;
    params.pd.gravity_compensation = false;
    Cell without(params);
    EXPECT_FALSE(without.simulator.AdvanceTo(2).ended);
    EXPECT_GT((without[without.loop.world.state].q - robot.stance).cwiseAbs().maxCoeff(), friction + 5e-3);
  }
}

TEST(QuadrupedStandTest, LandsFromADropAndStands) {
  QuadrupedStandParams params = Params(DogBot());
  params.world.plant.initial.p_WB[2] += 0.1;
  Cell cell(params);
  EXPECT_FALSE(cell.simulator.AdvanceTo(2).ended);
  EXPECT_NEAR(cell[cell.loop.world.state].p_WB[2], DogBot().StanceHeight(), 5e-3);
  EXPECT_LT(cell[cell.loop.world.state].v_W.norm(), 1e-3);
}

TEST(QuadrupedStandTest, FallsWhenPushedOver) {
  QuadrupedStandParams params = Params(DogBot());
  PulseForceParams push;
  push.push.force_W = {0, 400, 0};
  push.start = 0.5;
  push.duration = 1;
  params.world.pulses = {push};
  Cell cell(params);
  const RunStatus status = cell.simulator.AdvanceTo(4);
  EXPECT_TRUE(status.ended);
  EXPECT_GT(status.time, 0.5);
  EXPECT_THAT(status.reason, ::testing::HasSubstr("loop.world.monitor.fall: the robot fell: its trunk is"));
}

// The feet carry what is on the robot: its weight, the payload's, and the vertical force of the surroundings.
TEST(QuadrupedStandTest, FeetCarryPayloadAndDisturbances) {
  QuadrupedStandParams params = Params(DogBot());
  params.world.plant.payload.mass = 10;
  params.world.plant.payload.com = {0, 0, 0.1};
  PulseForceParams push;
  push.push.force_W = {0, 0, -30};
  push.duration = 10;
  SineForceParams sine;
  sine.amplitude.force_W = {0, 0, -20};
  sine.end = 1;
  params.world.pulses = {push};
  params.world.sines = {sine};
  params.world.random = {{DogBot(), true, 0, 1e-9}};
  Cell cell(params);
  EXPECT_FALSE(cell.simulator.AdvanceTo(3).ended);
  double carried = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) carried += cell[cell.loop.world.foot_sensor.measured][leg][2];
  EXPECT_NEAR(carried, (DogBot().mass() + 10) * 9.81 + 30, 0.1);
  // At rest the inertial unit reads gravity and the torque sensors what the controller commands.
  EXPECT_NEAR(cell[cell.loop.world.imu.measurement].specific_force_B.norm(), 9.81, 0.3);
  EXPECT_THAT(cell[cell.loop.world.torque_sensor.measured], IsNear(cell[cell.loop.pd.torque], 1e-12));
}

}  // namespace
}  // namespace tenon::quadruped_stand_test
