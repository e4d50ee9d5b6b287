// A quadruped in MuJoCo, against the plant that it stands in for.

#include <tenon/tests/plants/legged/mujoco_quadruped.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::mujoco_quadruped_test {

QuadrupedPlantParams WithLoad() {
  QuadrupedPlantParams params{.robot = test::DogBot(), .initial = test::Standing(test::DogBot())};
  params.payload = {3, {0.1, 0.05, 0.2}, Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal()};
  return params;
}

TEST(MujocoQuadrupedTest, AcceleratesInTheAirAsThePlant) {
  RandomStream random(3);
  QuadrupedPlantParams params = WithLoad();
  params.robot.drive.damping = params.robot.drive.friction = 0;
  params.initial.p_WB[2] = 2;
  params.initial.q_WB = test::RandomVector<4>(random, 1).normalized();
  params.initial.v_W = test::RandomVector<3>(random, 1);
  params.initial.w_W = test::RandomVector<3>(random, 2);
  params.initial.qd = test::RandomVector<12>(random, 3);
  ExternalForces external{};
  external[0] = {0, {0.1, 0.2, 0.05}, {20, -10, 5}, {1, 2, 3}};
  external[3] = {6, {0.01, 0.02, -0.2}, {-7, 9, 30}, {0.1, 0.2, 0.3}};
  const Vec<12> torque = test::RandomVector<12>(random, 10);

  TestRig<QuadrupedPlant> plant(params);
  plant.Fix(plant->torque, torque).Fix(plant->external, external);
  TestRig<test::MujocoQuadruped> mujoco(test::MujocoQuadrupedParams{.plant = params, .steps_per_ms = 10});
  mujoco.Fix(mujoco->torque, torque).Fix(mujoco->external, external);
  mujoco.RunTo(0.5e-4);  // one step

  const LeggedAcceleration a = plant[plant->acceleration], b = mujoco[mujoco->acceleration];
  EXPECT_THAT(b.a_W, IsNear(a.a_W, 1e-8));
  EXPECT_THAT(b.alpha_W, IsNear(a.alpha_W, 1e-7));
  EXPECT_THAT(b.qdd, IsNear(a.qdd, 1e-6));
  const WrenchEstimate wrench = plant[plant->external_wrench], same = mujoco[mujoco->external_wrench];
  EXPECT_THAT(same.force_W, IsNear(wrench.force_W, 1e-10));
  EXPECT_THAT(same.torque_W, IsNear(wrench.torque_W, 1e-10));
  EXPECT_THAT(mujoco[mujoco->external_torque], IsNear(plant[plant->external_torque], 1e-10));
  EXPECT_NEAR(mujoco[mujoco->energy].kinetic, plant[plant->energy].kinetic, 1e-8);
}

TEST(MujocoQuadrupedTest, StandsOnASlopeWithItsWeightOnTheFeet) {
  QuadrupedPlantParams params = WithLoad();
  params.robot.drive.damping = 2000;  // it sinks slowly
  params.terrain.grade = {0.2, 0.1};
  params.initial = StandingOn(params.robot, {.slope = params.terrain.grade});
  TestRig<test::MujocoQuadruped> rig(test::MujocoQuadrupedParams{.plant = params});
  rig.Fix(rig->torque, Vec<12>::Zero()).RunTo(0.3);
  const FootForces forces = rig[rig->foot_forces];
  Vec<3> sum = Vec<3>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) sum += forces[leg];
  const double weight = (params.robot.mass() + params.payload.mass) * params.gravity;
  EXPECT_THAT(sum, IsNear(Vec<3>(0, 0, weight), 0.01 * weight));
  EXPECT_GT(rig[rig->foot_depths].minCoeff(), 0);
  for (const Vec<3>& slip : rig[rig->foot_slips]) EXPECT_LT(slip.norm(), 0.01);
}

// A limp robot falls from 5 cm and comes to lie on trunk, knees and feet, tilted by 30 degrees. MuJoCo's
// trunk is a box with sharp edges and its friction sticks, so a Go2 rests 2 mm and a degree apart, a B2 5 mm
// and 9.
TEST(MujocoQuadrupedTest, ALimpRobotFallsAndLiesAsThePlant) {
  const auto tilt = [](const LeggedState& x) { return std::acos(x.R_WB()(2, 2)); };
  for (const char* name : {"go2", "b2"}) {
    QuadrupedPlantParams params{.robot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/" + name + ".yaml")};
    params.initial = StandingOn(params.robot, {});
    params.initial.p_WB[2] += 0.05;
    params.initial.q_WB = QuaternionFromRotationVector({0.05, 0.02, 0});
    DiagramBuilder builder;
    auto& plant = builder.Add<QuadrupedPlant>("plant", params);
    Simulator simulator(builder.BuildWithOpenInputs(), {.order = 2, .rtol = 1e-2, .atol = 1e-4});
    simulator.context().Set(plant.torque, Vec<12>::Zero());
    test::MujocoRobot mujoco({.plant = params, .lies = true});
    test::MujocoStep other{.state = params.initial};
    int steps = 0;  // of MuJoCo, 4 per millisecond
    for (const double time : {0.1, 0.2, 2.0}) {
      simulator.RunTo(time);
      for (; steps < std::lround(4000 * time); ++steps) mujoco.Step(Vec<12>::Zero(), {}, &other);
      const LeggedState& x = simulator.context().Eval(plant.state);
      const bool falls = time < 1;
      EXPECT_NEAR(x.p_WB[2], other.state.p_WB[2], falls ? 0.002 : 0.008) << name << " " << time;
      EXPECT_NEAR(tilt(x), tilt(other.state), falls ? 0.005 : 0.17) << name << " " << time;
      if (!falls) EXPECT_LT(x.v_W.norm(), 0.01) << name << " lies";
    }
  }
}

TEST(MujocoQuadrupedTest, AnAssignedRobotTakesTheSameStep) {
  const QuadrupedPlantParams params = WithLoad();
  QuadrupedPlantParams heavier = params;
  heavier.payload.mass = 9;
  test::MujocoRobot robot({.plant = params}), other({.plant = heavier});
  other = robot;
  test::MujocoStep one{.state = params.initial}, same = one;
  robot.Step(Vec<12>::Ones(), {}, &one);
  other.Step(Vec<12>::Ones(), {}, &same);
  EXPECT_EQ(one.state.qd, same.state.qd);
  EXPECT_EQ(one.external_wrench.force_W, same.external_wrench.force_W);
}

TEST(MujocoQuadrupedTest, RefusesWhatItCannotModel) {
  test::MujocoQuadrupedParams params{.plant = WithLoad()};
  params.plant.extend = [](QuadrupedMultibody&) {};
  EXPECT_THROW(test::MujocoQuadruped{params}, ParameterError);
}

}  // namespace tenon::mujoco_quadruped_test
