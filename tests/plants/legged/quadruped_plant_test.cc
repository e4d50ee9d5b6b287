#include <tenon/plants/legged/fall_monitor.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::quadruped_plant_test {

using test::A1, test::DogBot, test::RandomState, test::RandomVector, test::Stacked, test::Standing;
using Rig = TestRig<QuadrupedPlant>;

constexpr double kGravity = 9.81;

QuadrupedPlantParams Params(const QuadrupedDescription& robot) {
  return {.robot = robot, .initial = Standing(robot)};
}

/// The robot without friction and end stops.
QuadrupedDescription Lossless(QuadrupedDescription robot) {
  robot.drive.damping = robot.drive.friction = 0;
  for (LegDescription& leg : robot.legs)
    for (JointDescription& joint : leg.joints) joint.lower = -INFINITY, joint.upper = INFINITY;
  return robot;
}

LeggedState High(LeggedState x) {
  x.p_WB[2] = 100;
  return x;
}

/// Accelerations of the controllers' model under the plant's torques and forces.
Vec<18> ModelAcceleration(const QuadrupedPlant& plant, Rig& rig, const ExternalForces& external) {
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(plant.params.robot), rig[plant.state]);
  Vec<18> force = -dynamics.bias();
  force.tail<12>() += rig[plant.joint_torque];
  const LeggedState& x = rig[plant.state];
  const auto add = [&](int leg, int joints, const Vec<3>& p_W, const Vec<3>& f) {
    force.head<3>() += f;
    force.segment<3>(3) += (p_W - x.p_WB).cross(f);
    if (leg >= 0)
      force.segment(6 + 3 * leg, joints) += dynamics.LegJacobian(leg, p_W).leftCols(joints).transpose() * f;
  };
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const FootContact& foot = rig[plant.contacts].feet[leg];
    add(leg, 3, foot.p_W, foot.force_W);
  }
  const BodyContact::Forces& bodies = rig[plant.contacts].bodies;
  for (std::size_t i = 0; i < bodies.count; ++i) {
    const auto& [body, p_W, f, torque] = bodies.at[i];
    add(body == 0 ? -1 : (body - 1) / 3, body == 0 ? 0 : (body - 1) % 3 + 1, p_W, f);
    force.segment<3>(3) += torque;  // of several spheres of the trunk
  }
  for (const ExternalForce& at : external) {
    Vec<3> p = at.p_B;
    Eigen::Matrix3d R = x.R_WB();
    Vec<3> origin = x.p_WB;
    const int leg = at.body == 0 ? -1 : (at.body - 1) / 3, joints = at.body == 0 ? 0 : (at.body - 1) % 3 + 1;
    for (int i = 0; i < joints; ++i) {
      const JointDescription& joint = plant.params.robot.joint(3 * leg + i);
      origin += R * joint.p_PJ;
      R = R * Eigen::AngleAxisd(x.q[3 * leg + i], joint.axis);
    }
    add(leg, joints, origin + R * p, at.force_W);
  }
  return test::Solve(dynamics.M, force);
}

// External forces add (force, torque about B, torques of the joints) to M nu'.
TEST(QuadrupedPlantTest, OutputsTheGeneralisedExternalForces) {
  Rig rig(Params(Lossless(DogBot())));
  RandomStream random(5);
  LeggedState x = RandomState(random);
  x.p_WB[2] = 5;
  rig.Set(rig->motion, x).Fix(rig->torque, Vec<12>::Zero());
  const auto acceleration = [&](const ExternalForces& external) {
    rig.Fix(rig->external, external);
    return Stacked(rig[rig->acceleration]);
  };
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(rig->params.robot), rig[rig->state]);
  for (const int body : {0, 1, 5, 12}) {
    const Vec<18> without = acceleration({});
    const ExternalForces external{ExternalForce{body, RandomVector<3>(random, 0.3),
                                                RandomVector<3>(random, 50), RandomVector<3>(random, 5)}};
    const Vec<18> added = dynamics.M * (acceleration(external) - without);
    const WrenchEstimate& wrench = rig[rig->external_wrench];
    EXPECT_THAT(added.head<3>(), IsNear(wrench.force_W, 1e-8));
    EXPECT_THAT(added.segment<3>(3),
                IsNear(wrench.torque_W + (dynamics.com_W - x.p_WB).cross(wrench.force_W), 1e-8));
    EXPECT_THAT(added.tail<12>(), IsNear(rig[rig->external_torque], 1e-8)) << body;
  }
}

// A payload moves like a part of the trunk; the outputs report its weight as an external wrench.
TEST(QuadrupedPlantTest, CarriesAPayloadAsADisturbance) {
  RandomStream random(6);
  QuadrupedPlantParams loaded = Params(DogBot());
  loaded.payload.mass = 7;
  loaded.payload.com = {0.1, -0.05, 0.15};
  loaded.payload.inertia.diagonal() << 0.02, 0.03, 0.04;
  QuadrupedPlantParams heavy = Params(WithPayload(DogBot(), loaded.payload));
  LeggedState x = RandomState(random);
  x.p_WB[2] = 5;
  struct Outputs {
    Vec<3> a_W;
    double energy;
    WrenchEstimate wrench;
  };
  const auto at = [&](const QuadrupedPlantParams& params, const ExternalForces& external) -> Outputs {
    Rig rig(params);
    rig.Set(rig->motion, x).Fix(rig->torque, Vec<12>::Ones()).Fix(rig->external, external);
    return {rig[rig->acceleration].a_W, rig[rig->energy].total(), rig[rig->external_wrench]};
  };
  const ExternalForces push{ExternalForce{0, {0, 0.1, 0}, {10, 20, 30}}};
  const Outputs with = at(loaded, push), as_part = at(heavy, push);
  const Outputs as_force =
      at(Params(DogBot()), {push[0], {0, loaded.payload.com, {0, 0, -7 * loaded.gravity}}});
  EXPECT_THAT(with.a_W, IsNear(as_part.a_W, 1e-10));
  EXPECT_NEAR(with.energy, as_part.energy, 1e-9);
  EXPECT_THAT(with.wrench.force_W, IsNear(as_force.wrench.force_W, 1e-12));
  EXPECT_THAT(with.wrench.torque_W, IsNear(as_force.wrench.torque_W, 1e-10));
}

TEST(QuadrupedPlantTest, AgreesWithTheModel) {
  for (const QuadrupedDescription& robot : {Lossless(DogBot()), Lossless(A1())}) {
    Rig rig(Params(robot));
    const QuadrupedPlant& plant = rig.system();
    RandomStream random(31);
    double most = 0;
    for (int i = 0; i < 30; ++i) {
      LeggedState x = RandomState(random);
      x.p_WB[2] = random.Uniform(0.2, 0.6);
      x.q_WB = QuaternionFromRotationVector(RandomVector<3>(random, 0.3));
      x.v_W *= 0.1, x.w_W *= 0.1, x.qd *= 0.1;
      ExternalForces external;
      for (int k = 0; k < 4; ++k)
        external[k] = {static_cast<int>(random.Uniform(0, 13)), RandomVector<3>(random, 0.3),
                       RandomVector<3>(random, 80)};
      rig.Set(plant.motion, x).Set(plant.bristles, FootBristles{RandomVector<8>(random, 1e-3)});
      rig.Fix(plant.torque, RandomVector<12>(random, 80)).Fix(plant.external, external);
      const Vec<18> expected = ModelAcceleration(plant, rig, external);
      EXPECT_THAT(Stacked(rig[plant.acceleration]), IsNear(expected, 1e-10 * (1 + expected.norm())));
      for (int leg = 0; leg < kNumLegs; ++leg) most = std::max(most, rig[plant.foot_forces][leg].norm());
    }
    EXPECT_GT(most, 100);  // feet took part
  }
}

TEST(QuadrupedPlantTest, TheLengthOfTheQuaternionMeansNothingAndReturnsToOne) {
  RandomStream random(33);
  LeggedState x = High(RandomState(random));
  Rig rig(Params(DogBot()));
  rig.Fix(rig->torque, Vec<12>::Zero()).Set(rig->motion, x);
  const LeggedAcceleration before = rig[rig->acceleration];
  x.q_WB *= 1.3;
  rig.Set(rig->motion, x);
  EXPECT_THAT(rig[rig->state].q_WB, IsNear(x.q_WB / 1.3, 1e-15));
  EXPECT_THAT(rig[rig->acceleration].qdd, IsNear(before.qdd, 1e-9));
  EXPECT_LT(rig[rig->motion_rate].q_WB.dot(x.q_WB), 0);
}

TEST(QuadrupedPlantTest, InTheAirMomentumAndEnergyStay) {
  for (const QuadrupedDescription& robot : {Lossless(DogBot()), Lossless(A1())}) {
    RandomStream random(32);
    QuadrupedPlantParams params = Params(robot);
    params.initial = High(RandomState(random));
    params.limit_speed = false;  // above its largest speed a drive brakes
    Rig rig(params);
    rig.Fix(rig->torque, Vec<12>::Zero());
    const QuadrupedModel model(robot);
    QuadrupedDynamics before, after;
    model.Calc(rig[rig->state], &before);
    const double energy = rig[rig->energy].total();
    const double T = 0.5;
    rig.RunTo(T);
    model.Calc(rig[rig->state], &after);
    const Eigen::Vector3d g(0, 0, -kGravity);
    EXPECT_THAT(after.com_W, IsNear(before.com_W + T * before.com_velocity_W + T * T / 2 * g, 1e-7));
    EXPECT_THAT(after.com_velocity_W, IsNear(before.com_velocity_W + T * g, 1e-7));
    EXPECT_THAT(after.angular_momentum_W, IsNear(before.angular_momentum_W, 1e-7));
    EXPECT_NEAR(rig[rig->energy].total(), energy, 1e-6 * energy);
    EXPECT_NEAR(rig[rig->motion].q_WB.norm(), 1, 1e-7);
    EXPECT_GT((rig[rig->state].q - params.initial.q).norm(), 0.5);  // the legs did move
  }
}

TEST(QuadrupedPlantTest, FrictionTakesEnergy) {
  QuadrupedPlantParams params = Params(A1());
  params.initial = High(params.initial);
  params.initial.qd.setConstant(1);
  Rig rig(params);
  rig.Fix(rig->torque, Vec<12>::Zero());
  // Power of friction at the start: viscous and Coulomb's, on twelve joints.
  const double before = rig[rig->energy].total(), h = 1e-5;
  rig.RunTo(h);
  EXPECT_NEAR((rig[rig->energy].total() - before) / h, -12 * (0.05 + 0.2 * std::tanh(10)), 0.02);
}

TEST(QuadrupedPlantTest, TorqueFallsWithSpeedIfAsked) {
  for (const bool limited : {false, true}) {
    QuadrupedPlantParams params = Params(DogBot());  // 60 N m, 6 rad/s, full torque up to 3 rad/s
    params.limit_speed = limited;
    params.initial.qd << 3, 4.5, 6, 9, 12, -4.5, 4.5, -6, 0, 0, 0, 0;
    Rig rig(params);
    Vec<12> command = Vec<12>::Constant(100), expected = Vec<12>::Constant(60);
    command[6] = expected[6] = -50;  // braking is not limited
    if (limited) expected.head<5>() << 60, 30, 0, -60, -60;
    rig.Fix(rig->torque, command);
    EXPECT_THAT(rig[rig->joint_torque], IsNear(expected, 1e-12));
  }
}

TEST(QuadrupedPlantTest, EndStopsPushBack) {
  QuadrupedPlantParams params = Params(A1());
  params.robot.drive.damping = params.robot.drive.friction = 0;
  params.gravity = 0;
  params.initial = High(params.initial);
  const auto qdd = [&](double beyond, double speed) {
    params.initial.q[2] = params.robot.joint(2).upper + beyond;
    params.initial.qd[2] = speed;
    Rig rig(params);
    rig.Fix(rig->torque, Vec<12>::Zero());
    const Vec<18> a = Stacked(rig[rig->acceleration]);
    const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(params.robot, 0), rig[rig->state]);
    return (dynamics.M * a + dynamics.coriolis)[8];  // the torque of the stop
  };
  EXPECT_NEAR(qdd(-0.01, 3), 0, 1e-9);
  EXPECT_NEAR(qdd(0.01, 0), -300 * 0.01, 1e-9);
  EXPECT_NEAR(qdd(0.01, 2), -300 * 0.01 * (1 + 0.5 * 2), 1e-9);
  EXPECT_NEAR(qdd(0.01, -5), 0, 1e-9);  // it does not pull
}

/// The tolerances that QuadrupedPlant recommends.
SimulatorOptions Options() {
  return {.order = 2,
          .rtol = 1e-2,
          .atol = 1e-4,
          .state_atol = {{"plant.motion.v_W", 1e-2},
                         {"plant.motion.w_W", 1e-2},
                         {"plant.motion.qd", 1e-2},
                         {"plant.bristles", 1e-6}}};
}

/// A robot that holds its stance by joint PD, and a force on its trunk.
struct Stand {
  explicit Stand(const QuadrupedPlantParams& params, const Vec<3>& push = Vec<3>::Zero(), double from = 0,
                 const SimulatorOptions& options = Options()) {
    plant = &builder.Add<QuadrupedPlant>("plant", params);
    auto& pd = builder.AddFunction("pd", Sampled{Hz(1000)}, Uses(plant->state),
                                   [stance = params.robot.stance](const LeggedState& x) -> Vec<12> {
                                     return 500 * (stance - x.q) - 10 * x.qd;
                                   });
    auto& force = builder.AddFunction("push", Sampled{Hz(1000)}, Uses(builder.time), [=](double t) {
      ExternalForces forces;
      if (t >= from) forces[0] = {0, Vec<3>::Zero(), push};
      return forces;
    });
    builder.Connect(pd, plant->torque);
    builder.Connect(force, plant->external);
    diagram = builder.Build();
    simulator.emplace(*diagram, options);
  }
  template <class S>
  const typename S::Value& operator[](const S& source) {
    return simulator->context().Eval(source);
  }
  DiagramBuilder builder;
  QuadrupedPlant* plant;
  std::shared_ptr<const Diagram> diagram;
  std::optional<Simulator> simulator;
};

TEST(QuadrupedPlantTest, StandsOnItsWeight) {
  for (const QuadrupedDescription& robot : {DogBot(), A1()}) {
    Stand stand(Params(robot));
    stand.simulator->RunTo(3);
    Vec<3> sum = Vec<3>::Zero();
    for (int leg = 0; leg < kNumLegs; ++leg) {
      sum += stand[stand.plant->foot_forces][leg];
      EXPECT_GT(stand[stand.plant->foot_forces][leg][2], 0.1 * robot.mass() * kGravity);
    }
    const double weight = robot.mass() * kGravity;
    EXPECT_THAT(sum, IsNear(Vec<3>(0, 0, weight), 1e-3 * weight));
    EXPECT_LT(stand[stand.plant->foot_depths].maxCoeff(), 2e-3);
    EXPECT_GT(stand[stand.plant->foot_depths].minCoeff(), 0);
    EXPECT_LT(stand[stand.plant->state].v_W.norm(), 1e-4);
  }
}

TEST(QuadrupedPlantTest, DoesNotCreepUnderASidePush) {
  QuadrupedPlantParams params = Params(DogBot());
  params.terrain.friction = 0.7;
  Stand stand(params, Vec<3>(0, 20, 0), 1);
  stand.simulator->RunTo(3);
  const Vec<3> start = stand[stand.plant->state].p_WB;
  stand.simulator->RunTo(8);
  EXPECT_LT((stand[stand.plant->state].p_WB - start).norm(), 1e-4);
  double sideways = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) sideways += stand[stand.plant->foot_forces][leg][1];
  EXPECT_NEAR(sideways, -20, 0.1);
}

// A landing with 1 m/s to the side takes at most 3 times as many evaluations on any ground as with mu = 0.6.
TEST(QuadrupedPlantTest, NoGroundIsTooSlipperyOrTooRough) {
  const auto evaluations = [](double friction) {
    QuadrupedPlantParams params = Params(DogBot());
    params.terrain.friction = friction;
    params.initial.p_WB[2] += 0.02;
    params.initial.v_W = {0, 1, 0};
    Stand stand(params);
    stand.simulator->RunTo(0.5);
    EXPECT_TRUE(stand[stand.plant->state].p_WB.allFinite()) << friction;
    return stand.simulator->statistics().evaluations;
  };
  const long usual = evaluations(0.6);
  for (const double friction :
       {0.0, 5e-324, 1e-300, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 3.0, 10.0})
    EXPECT_LE(evaluations(friction), 3 * usual) << friction;
}

TEST(QuadrupedPlantTest, TheRecommendedTolerancesGiveATenthOfAMillimetre) {
  QuadrupedPlantParams params = Params(DogBot());
  params.initial.p_WB[2] += 0.05;
  params.initial.v_W = {0.3, 0.1, 0};
  Stand quick(params), exact(params);
  exact.simulator.emplace(*exact.diagram, SimulatorOptions{.order = 5, .rtol = 1e-8, .atol = 1e-9});
  for (const double t : {0.1, 0.2, 0.3}) {
    quick.simulator->RunTo(t);
    exact.simulator->RunTo(t);
    EXPECT_THAT(quick[quick.plant->state].p_WB, IsNear(exact[exact.plant->state].p_WB, 1e-4)) << t;
  }
}

TEST(QuadrupedPlantTest, RefusesForcesOnBodiesThatAreNotThere) {
  Rig rig(Params(DogBot()));
  ExternalForces forces;
  forces[0].body = 13;
  rig.Fix(rig->torque, Vec<12>::Zero()).Fix(rig->external, forces);
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->acceleration]; }, "body 13"));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->external_wrench]; }, "body 13"));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->external_torque]; }, "body 13"));
}

TEST(QuadrupedPlantTest, RefusesParametersThatMakeNoSense) {
  const auto refuses = RefusesChanged<QuadrupedPlant>(Params(DogBot()));
  EXPECT_TRUE(refuses([](auto& p) { p.robot = {}; }, "robot"));
  EXPECT_TRUE(refuses([](auto& p) { p.robot.foot_radius = 0.2; }, "radius"));
  EXPECT_TRUE(refuses([](auto& p) { p.payload.com[1] = NAN; }, "payload"));
  EXPECT_TRUE(refuses([](auto& p) { p.payload.mass = -2; }, "payload"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.q_WB.setZero(); }, "quaternion"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.q[3] = NAN; }, "initial"));
  EXPECT_TRUE(refuses([](auto& p) { p.gravity = INFINITY; }, "gravity"));
  EXPECT_TRUE(refuses([](auto& p) { p.terrain.friction = -1; }, "friction"));
}

LeggedState At(const Vec<3>& p_WB, double roll = 0) {
  return {.p_WB = p_WB, .q_WB = QuaternionFromRotationVector({roll, 0, 0})};
}

TEST(FallMonitorTest, EndsTheRunWhenTheTrunkIsLow) {
  TestRig<FallMonitor> rig(FallMonitorParams{.min_height = 0.2});
  rig.Fix(rig->state, At({0, 0, 0.201}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 0.1999999}));
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  // Rounded numbers may be equal, so the message does not compare them.
  EXPECT_THAT(status.reason, HasSubstrs("block.fall", "is 0.200 m above the ground; the limit is 0.200 m"));
}

TEST(FallMonitorTest, HeightCountsFromTheGroundBelow) {
  FallMonitorParams params{.min_height = 0.2};
  params.terrain.grade = {0.5, 0};
  TestRig<FallMonitor> rig(params);
  rig.Fix(rig->state, At({-2, 0, -0.79}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({2, 0, 1.19}));
  EXPECT_TRUE(rig.simulator().AdvanceTo(1).ended);
}

TEST(FallMonitorTest, EndsTheRunWhenTheTrunkTilts) {
  TestRig<FallMonitor> rig(FallMonitorParams{.max_tilt = 0.8});
  rig.Fix(rig->state, At({0, 0, 1}, -0.79));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 1}, -0.81));
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  EXPECT_THAT(status.reason, HasSubstrs("block.fall", "0.810 rad", "0.800 rad"));
}

TEST(FallMonitorTest, EndsTheRunWhenTheRobotFlies) {
  TestRig<FallMonitor> rig;
  rig.Fix(rig->state, At({0, 0, 9.9}));
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Fix(rig->state, At({0, 0, 21e3}));
  EXPECT_THAT(rig.simulator().AdvanceTo(1).reason, HasSubstrs("block.flight", "10.000 m"));
}

TEST(FallMonitorTest, RefusesLimitsThatMakeNoSense) {
  EXPECT_TRUE(Refuses<FallMonitor>({.min_height = 1, .max_height = 1}, "max_height"));
}

TEST(FallMonitorTest, LimitsAreSetInARun) {
  TestRig<FallMonitor> rig(FallMonitorParams{.min_height = 0.2, .max_tilt = 0.8});
  rig.Fix(rig->state, At({0, 0, 0.15}, 0.9)).Set(rig->min_height, 0.1).Set(rig->max_tilt, 1);
  EXPECT_FALSE(rig.simulator().AdvanceTo(0.5).ended);
  rig.Set(rig->max_tilt, 0.85);
  EXPECT_THAT(rig.simulator().AdvanceTo(1).reason, HasSubstrs("0.900 rad", "0.850 rad"));
}

}  // namespace tenon::quadruped_plant_test
