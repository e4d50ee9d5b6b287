// A quadruped with additions in Simbody: agreement with the plain plant, conservation laws, closed forms.

#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon::quadruped_multibody_test {

using test::A1, test::DogBot, test::RandomState, test::RandomVector, test::SkewDogBot, test::Stacked,
    test::Standing;
using Rig = TestRig<QuadrupedPlant>;
using SimTK::Vec3;

constexpr double kGravity = 9.81;
constexpr double kLength = 0.4;  // of pendulums [m]

void AddNothing(QuadrupedMultibody&) {}

SimTK::Body::Rigid Ball(double mass, double radius = 0.05) {
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, Vec3(0), SimTK::UnitInertia::sphere(radius)));
}

/// A pendulum about the trunk's y axis.
SimTK::MobilizedBody::Pin AddPendulum(QuadrupedMultibody& robot, double mass = 2, double angle = 0) {
  const SimTK::Rotation about_y(-SimTK::Pi / 2, SimTK::XAxis);  // z of the joint is y of the trunk
  SimTK::MobilizedBody::Pin pin(robot.trunk(), SimTK::Transform(about_y, Vec3(0.1, 0, 0.05)), Ball(mass),
                                SimTK::Transform(about_y, Vec3(0, 0, kLength)));
  pin.setDefaultAngle(angle);
  robot.Name(pin, "swing");
  return pin;
}

/// A pendulum, a load in a ball joint on a shank, and a box on six springs.
void AddMuch(QuadrupedMultibody& robot) {
  AddPendulum(robot, 2, 0.5);
  SimTK::MobilizedBody::Ball ball(robot.link(DogBot().joint(5).name), Vec3(0, 0, -0.1), Ball(0.5),
                                  Vec3(0, 0.1, 0));
  robot.Name(ball, "ball");
  SimTK::MobilizedBody::Free backpack(robot.trunk(), Vec3(0, 0, 0.2), Ball(3, 0.1), Vec3(0));
  SimTK::Force::LinearBushing(robot.forces, robot.trunk(), Vec3(0, 0, 0.2), backpack, Vec3(0),
                              SimTK::Vec6(20, 20, 20, 2000, 2000, 2000),
                              SimTK::Vec6(0.5, 0.5, 0.5, 20, 20, 20));
}

QuadrupedPlantParams Params(const QuadrupedDescription& robot, const ExtendQuadruped& extend) {
  return {.robot = robot, .initial = Standing(robot), .extend = extend};
}

/// A robot in the air without friction, end stops and limits of its drives.
QuadrupedPlantParams InTheAir(QuadrupedDescription robot, const ExtendQuadruped& extend) {
  robot.drive.damping = robot.drive.friction = 0;
  for (LegDescription& leg : robot.legs)
    for (JointDescription& joint : leg.joints) joint.lower = -INFINITY, joint.upper = INFINITY;
  QuadrupedPlantParams params = Params(robot, extend);
  params.limit_speed = false;
  params.initial.p_WB[2] = 100;
  return params;
}

QuadrupedDescription WithRotors(QuadrupedDescription robot) {
  robot.drive.rotor_inertia = 0.03;
  return robot;
}

TEST(QuadrupedMultibodyTest, AgreesWithThePlainPlant) {
  RandomStream random(71);
  int in_contact = 0;
  for (const QuadrupedDescription& robot : {DogBot(), A1(), SkewDogBot(), WithRotors(SkewDogBot())}) {
    QuadrupedPlantParams params = Params(robot, AddNothing);
    params.payload.mass = 3;
    params.payload.com = {0.1, -0.05, 0.15};
    params.payload.inertia.diagonal() << 0.02, 0.03, 0.04;
    Rig extended(params);
    params.extend = nullptr;
    Rig plain(params);
    for (int i = 0; i < 250; ++i) {
      LeggedState x = RandomState(random);
      x.p_WB[2] = random.Uniform(0.1, 0.6);
      x.v_W *= 0.1;
      ExternalForces external;
      for (int k = 0; k < 4; ++k)
        external[k] = {static_cast<int>(random.Uniform(0, 13)), RandomVector<3>(random, 0.3),
                       RandomVector<3>(random, 80), RandomVector<3>(random, 10)};
      const Vec<12> torque = RandomVector<12>(random, 80);
      const FootBristles bristles{RandomVector<8>(random, 1e-3)};
      for (Rig* rig : {&extended, &plain})
        rig->Set((*rig)->motion, x)
            .Set((*rig)->bristles, bristles)
            .Fix((*rig)->torque, torque)
            .Fix((*rig)->external, external);
      const Vec<18> expected = Stacked(plain[plain->acceleration]);
      EXPECT_THAT(Stacked(extended[extended->acceleration]), IsNear(expected, 1e-10 * expected.norm()));
      const LeggedEnergy energy = plain[plain->energy];
      EXPECT_NEAR(extended[extended->energy].kinetic, energy.kinetic, 1e-11 * energy.kinetic);
      EXPECT_NEAR(extended[extended->energy].potential, energy.potential, 1e-11 * energy.potential);
      if (plain[plain->foot_depths].maxCoeff() > 0) ++in_contact;
    }
  }
  EXPECT_GT(in_contact, 300);
}

/// Momentum and centre of mass of a plant with additions, by a System of the test.
struct Momentum {
  Momentum(Rig& rig, const ExtendQuadruped& extend) : of(rig->params.robot, rig->params.gravity) {
    extend(of);
    of.system.realizeTopology();
    SimTK::State state = of.system.getDefaultState();
    of.system.realizeModel(state);
    const LeggedState& x = rig[rig->state];
    SimTK::Vector& q = state.updQ();
    SimTK::Vector& u = state.updU();
    for (int i = 0; i < 4; ++i) q[i] = x.q_WB[i];
    for (int i = 0; i < 3; ++i) q[4 + i] = x.p_WB[i], u[i] = x.w_W[i], u[3 + i] = x.v_W[i];
    for (int j = 0; j < kNumJoints; ++j) {
      q[of.body(1 + j).getFirstQIndex(state)] = x.q[j];
      u[of.body(1 + j).getFirstUIndex(state)] = x.qd[j];
    }
    int next_q = 0, next_u = 0;
    for (SimTK::MobilizedBodyIndex i(14); i < of.matter.getNumBodies(); ++i) {
      const SimTK::MobilizedBody& body = of.matter.getMobilizedBody(i);
      for (int k = 0; k < body.getNumQ(state); ++k)
        q[body.getFirstQIndex(state) + k] = rig[rig->added_positions][next_q++];
      for (int k = 0; k < body.getNumU(state); ++k)
        u[body.getFirstUIndex(state) + k] = rig[rig->added_speeds][next_u++];
    }
    of.system.realize(state, SimTK::Stage::Velocity);
    const SimTK::SpatialVec momentum = of.matter.calcSystemCentralMomentum(state);
    const Vec3 c = of.matter.calcSystemMassCenterLocationInGround(state);
    for (int i = 0; i < 3; ++i) angular[i] = momentum[0][i], linear[i] = momentum[1][i], com[i] = c[i];
    mass = of.matter.calcSystemMass(state);
  }
  QuadrupedMultibody of;
  Vec<3> angular, linear, com;
  double mass;
};

TEST(QuadrupedMultibodyTest, InTheAirMomentumAndEnergyStay) {
  RandomStream random(72);
  QuadrupedPlantParams params = InTheAir(DogBot(), AddMuch);
  params.initial.qd = RandomVector<12>(random, 3);
  params.initial.w_W = RandomVector<3>(random, 2);
  params.initial.v_W = RandomVector<3>(random, 2);
  Rig rig(params);
  rig.Fix(rig->torque, Vec<12>::Zero());
  Eigen::VectorXd u = rig[rig->added_speeds];
  ASSERT_EQ(u.size(), 1 + 3 + 6);
  for (double& each : u) each = random.Uniform(-2, 2);
  rig.Set(rig->added_u, u);
  const Momentum before(rig, AddMuch);
  const auto total = [&] { return rig[rig->energy].total() + rig[rig->added_z].sum(); };
  const double energy = total();
  const double T = 0.5;
  rig.RunTo(T);
  const Momentum after(rig, AddMuch);
  const Vec<3> g(0, 0, -kGravity);
  EXPECT_THAT(after.linear, IsNear(before.linear + T * before.mass * g, 1e-6));
  EXPECT_THAT(after.com, IsNear(before.com + T * before.linear / before.mass + T * T / 2 * g, 1e-7));
  EXPECT_THAT(after.angular, IsNear(before.angular, 1e-6));
  ASSERT_EQ(rig[rig->added_z].size(), 1);  // energy lost in the springs
  EXPECT_GT(rig[rig->added_z][0], 0.1);
  EXPECT_NEAR(total(), energy, 1e-7 * energy);
}

TEST(QuadrupedMultibodyTest, APendulumOnAFixedTrunkHasItsPeriod) {
  for (const double start : {0.01, 2.5}) {
    Rig rig(InTheAir(A1(), [&](QuadrupedMultibody& robot) {
      const SimTK::MobilizedBody::Pin pin = AddPendulum(robot, 2, start);
      SimTK::Constraint::Weld(robot.matter.Ground(), SimTK::Transform(Vec3(0, 0, 100)), robot.trunk(),
                              SimTK::Transform());
    }));
    rig.Fix(rig->torque, Vec<12>::Zero());
    // A physical pendulum with the moment of inertia I swings like a point mass at the distance I / (m l).
    const double inertia = kLength * kLength + 0.4 * 0.05 * 0.05;  // per mass
    double a = 1, b = std::cos(start / 2);
    for (int i = 0; i < 10; ++i) a = std::exchange(b, std::sqrt(a * b)) / 2 + a / 2;
    const double period = 2 * std::numbers::pi / b * std::sqrt(inertia / (kLength * kGravity));
    rig.RunTo(period / 4);
    EXPECT_NEAR(rig[rig->added_positions][0], 0, 1e-6 * start);
    rig.RunTo(period);
    EXPECT_NEAR(rig[rig->added_positions][0], start, 1e-6 * start);
    EXPECT_NEAR(rig[rig->added_speeds][0], 0, 1e-5 * start);
    EXPECT_THAT(rig[rig->state].p_WB, IsNear(Vec<3>(0, 0, 100), 1e-7));
  }
}

/// The load's weight reaches the ground, and its motion the trunk.
TEST(QuadrupedMultibodyTest, TheReactionActsOnTheRobot) {
  Rig rig(InTheAir(DogBot(), [](QuadrupedMultibody& robot) {
    SimTK::MobilizedBody::Slider(robot.trunk(), SimTK::Transform(), Ball(5), SimTK::Transform());
  }));
  rig.Fix(rig->torque, Vec<12>::Zero());
  const double without = rig[rig->acceleration].a_W[0];
  rig.Fix(rig->added_forces, Eigen::VectorXd::Constant(1, 10.0));
  EXPECT_LT(rig[rig->acceleration].a_W[0], without - 0.1);
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0] + rig[rig->acceleration].a_W[0], 10.0 / 5, 1e-10);
}

struct Arm {
  Arm() {
    QuadrupedPlantParams params = Params(A1(), [](QuadrupedMultibody& robot) {
      SimTK::MobilizedBody::Pin shoulder = AddPendulum(robot, 0.5, 1);
      SimTK::MobilizedBody::Slider hand(shoulder, SimTK::Transform(), Ball(0.2), SimTK::Transform());
      robot.Draw(hand, Shape::Sphere(ShapeRole::kOther, "hand", 0.03));
    });
    plant = &builder.Add<QuadrupedPlant>("plant", params);
    auto& legs = builder.AddFunction("legs", Sampled{Hz(1000)}, Uses(plant->state),
                                     [stance = params.robot.stance](const LeggedState& x) -> Vec<12> {
                                       return 100 * (stance - x.q) - 2 * x.qd;
                                     });
    builder.Connect(legs, plant->torque);
    auto& pd = builder.AddFunction("pd", Uses(plant->added_positions, plant->added_speeds),
                                   [](const Eigen::VectorXd& q, const Eigen::VectorXd& u) -> Eigen::VectorXd {
                                     return 100 * (Eigen::Vector2d(-0.5, 0.1) - q) - 5 * u;
                                   });
    builder.Connect(pd, plant->added_forces);
    diagram = builder.Build();
  }
  DiagramBuilder builder;
  QuadrupedPlant* plant;
  std::shared_ptr<const Diagram> diagram;
  SimulatorOptions options{.order = 3, .rtol = 1e-4, .atol = 1e-6};
};

TEST(QuadrupedMultibodyTest, AddedJointsHaveNamedPorts) {
  const Arm arm;
  Simulator simulator(*arm.diagram, arm.options);
  const auto log = simulator.AddLog(Hz(100), {&arm.plant->added_positions, &arm.plant->added_speeds});
  simulator.RunTo(0.6);
  EXPECT_EQ(log->names(),
            (std::vector<std::string>{"time", "plant.added_positions.swing", "plant.added_positions.added_1",
                                      "plant.added_speeds.swing", "plant.added_speeds.added_1"}));
  const auto elements = simulator.context().Elements(arm.plant->added_forces);
  ASSERT_EQ(elements.size(), 2u);
  EXPECT_EQ(elements[0].unit, "N m");
  EXPECT_EQ(elements[1].unit, "N");
  const Eigen::VectorXd q = simulator.context().Eval(arm.plant->added_positions);
  EXPECT_NEAR(q[0], -0.5, 0.1);
  EXPECT_NEAR(q[1], 0.1, 0.05);
  // The hand's position from the pose of the trunk.
  const LeggedState& x = simulator.context().Eval(arm.plant->state);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(q[0], Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Vec<3> hand_B = Vec<3>(0.1, 0, 0.05) + R * Vec<3>(q[1], 0, -kLength);
  EXPECT_THAT(simulator.context().Eval(arm.plant->geometry).back().p_W,
              IsNear(x.p_WB + x.R_WB() * hand_B, 1e-12));
}

TEST(QuadrupedMultibodyTest, TheLengthOfAnAddedQuaternionMeansNothingAndReturnsToOne) {
  Rig rig(InTheAir(DogBot(), [](QuadrupedMultibody& robot) {
    SimTK::MobilizedBody::Ball ball(robot.trunk(), Vec3(0, 0, -0.1), Ball(0.5), Vec3(0.1, 0, 0));
    robot.Name(ball, "ball");
  }));
  EXPECT_EQ(rig->additions.q.spec.elements, "ball_0,ball_1,ball_2,ball_3");
  EXPECT_EQ(rig->additions.u.spec.elements, "ball_0,ball_1,ball_2");
  EXPECT_EQ(rig->additions.u.spec.units, "rad/s,rad/s,rad/s");
  rig.Fix(rig->torque, Vec<12>::Zero()).Set(rig->added_u, Eigen::Vector3d(1, 2, 3));
  const Eigen::VectorXd before = rig.Derivative(rig->added_u);
  rig.Set(rig->added_q, 1.3 * rig[rig->added_q]);
  EXPECT_THAT(rig.Derivative(rig->added_u), IsNear(before, 1e-9));
  rig.RunTo(1);
  EXPECT_NEAR(rig[rig->added_q].norm(), 1, 1e-4);
}

/// Two pendulums that a rod connects: it is assembled at the start, and its error decays.
TEST(QuadrupedMultibodyTest, ConstraintsAreAssembledAndStayMet) {
  Rig rig(InTheAir(A1(), [](QuadrupedMultibody& robot) {
    SimTK::MobilizedBody::Pin one = AddPendulum(robot, 1, 0.3);
    SimTK::MobilizedBody::Pin other(robot.trunk(), SimTK::Transform(Vec3(-0.2, 0, 0)), Ball(1),
                                    SimTK::Transform(Vec3(0, 0.3, 0)));
    SimTK::Constraint::Rod(one, Vec3(0), other, Vec3(0), 0.5);
  }));
  rig.Fix(rig->torque, Vec<12>::Zero());
  const auto error = [&] {
    const Eigen::VectorXd& q = rig[rig->added_positions];
    const Vec<3> one = Vec<3>(0.1, 0, 0.05) + kLength * Vec<3>(-std::sin(q[0]), 0, -std::cos(q[0]));
    const Vec<3> other = Vec<3>(-0.2, 0, 0) + 0.3 * Vec<3>(std::sin(q[1]), -std::cos(q[1]), 0);
    return (one - other).norm() - 0.5;
  };
  EXPECT_NEAR(error(), 0, 1e-8);
  rig.RunTo(0.3);
  EXPECT_NEAR(error(), 0, 1e-8);
  Eigen::VectorXd q = rig[rig->added_q];
  q[1] += 1e-3;
  rig.Set(rig->added_q, q);
  EXPECT_GT(std::abs(error()), 1e-5);
  rig.RunTo(0.8);
  EXPECT_NEAR(error(), 0, 1e-8);
}

TEST(QuadrupedMultibodyTest, RefusesAdditionsThatMakeNoSense) {
  const auto refuses = [](const ExtendQuadruped& extend, const auto&... parts) {
    return Throws<ParameterError>([&] { Rig rig(Params(DogBot(), extend)); }, parts...);
  };
  EXPECT_TRUE(refuses([](QuadrupedMultibody& m) { m.link("front_left_nee"); }, "front_left_knee"));
  EXPECT_TRUE(refuses([](QuadrupedMultibody& m) { m.Name(AddPendulum(m), "a,b"); }, "a,b"));
  EXPECT_TRUE(refuses([](QuadrupedMultibody& m) { AddPendulum(m), AddPendulum(m); }, "swing"));
  EXPECT_TRUE(refuses(
      [](QuadrupedMultibody& m) {
        SimTK::MobilizedBody::Pin pin = AddPendulum(m);
        SimTK::Motion::Steady(pin, 1.0);
      },
      "swing"));
  EXPECT_TRUE(refuses(
      [](QuadrupedMultibody& m) {
        SimTK::Constraint::Rod(m.matter.Ground(), Vec3(0), m.trunk(), Vec3(0), 7);
      },
      "Simbody"));
  EXPECT_TRUE(refuses(
      [](QuadrupedMultibody& m) { SimTK::MobilizedBody::Pin(m.trunk(), SimTK::Body::Massless()); }, "mass"));
  int calls = 0;
  EXPECT_TRUE(refuses(
      [&](QuadrupedMultibody& m) {
        if (calls++ > 0) AddPendulum(m);
      },
      "extend"));
}

TEST(QuadrupedMultibodyTest, RefusesTheWrongNumberOfForces) {
  Rig rig(InTheAir(DogBot(), [](QuadrupedMultibody& m) { AddPendulum(m); }));
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_TRUE(Throws<RunError>(
      [&] {
        rig.Fix(rig->added_forces, Eigen::VectorXd::Zero(2));
        rig[rig->acceleration];
      },
      "added"));
}

}  // namespace tenon::quadruped_multibody_test
