#include <tenon/plants/legged/disturbances.h>
#include <tenon/plants/legged/drive_errors.h>
#include <tenon/plants/legged/joint_lock.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon::disturbances_test {

using test::A1, test::DogBot, test::RandomState;

ExternalForce OnKnee() {
  return {.body = 3, .force_W = {20, 0, -5}, .torque_W = {0, 1, 0}};
}

TEST(PointOnLegTest, RunsFromTheFootOverTheKneeToTheHip) {
  const QuadrupedPlantParams params{.robot = A1()};
  TestRig<QuadrupedPlant> rig(params);
  RandomStream random(2);
  rig.Set(rig->motion, RandomState(random));
  const QuadrupedBody& body = rig[rig->body];
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto at = [&](double height) {
      const ExternalForce force = PointOnLeg(params.robot, leg, height);
      return body.Position(force.body, force.p_B);
    };
    const Vec<3> knee = body.Position(3 * leg + 3, Vec<3>::Zero());
    const Vec<3> hip = body.Position(3 * leg + 2, Vec<3>::Zero());
    EXPECT_THAT(at(0), IsNear(body.Foot(leg).p_W, 1e-12));
    EXPECT_THAT(at(0.5), IsNear(knee, 1e-12));
    EXPECT_THAT(at(0.5 + 1e-9), IsNear(knee, 1e-8));
    EXPECT_THAT(at(1), IsNear(hip, 1e-12));
    EXPECT_THAT(at(0.75), IsNear(Vec<3>((hip + knee) / 2), 1e-12));
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { PointOnLeg(params.robot, 4, 0.5); }, "leg 4"));
  EXPECT_TRUE(Throws<ParameterError>([&] { PointOnLeg(params.robot, 0, 1.5); }, "height"));
}

TEST(SineForceTest, IsTheEquation) {
  TestRig<SineForce> rig(SineForceParams{OnKnee(), 2.0, 0.5, 4.0});
  for (const double t : {0.0, 0.4, 0.5, 1.0, 2.75, 3.9, 4.0, 5.0}) {
    rig.RunTo(t);
    const double wave = t >= 0.5 && t < 4 ? std::sin(2 * (t - 0.5)) : 0;
    const ExternalForce& force = rig[rig->force];
    EXPECT_EQ(force.body, 3);
    EXPECT_THAT(force.force_W, IsNear(Vec<3>(20 * wave, 0, -5 * wave), 1e-12)) << t;
    EXPECT_THAT(force.torque_W, IsNear(Vec<3>(0, wave, 0), 1e-12)) << t;
  }
}

TEST(PulseForceTest, IsThereForItsTime) {
  // 0.3 + 0.1 is no multiple of 1 ms in binary; the pulse still lasts 100 ticks.
  TestRig<PulseForce> rig(PulseForceParams{OnKnee(), 0.3, 0.1});
  int on = 0;
  double first = -1;
  for (int i = 0; i < 1000; ++i) {
    const ExternalForce& force = rig.Tick()[rig->force];
    if (force.force_W.isZero(0)) continue;
    if (on++ == 0) first = rig.time();
    EXPECT_EQ(force.force_W, OnKnee().force_W);
    EXPECT_EQ(force.torque_W, OnKnee().torque_W);
  }
  EXPECT_EQ(on, 100);
  EXPECT_DOUBLE_EQ(first, 0.3);
  TestRig<PulseForce> stays(PulseForceParams{OnKnee(), 0, INFINITY});
  EXPECT_EQ(stays.RunTo(100)[stays->force].force_W, OnKnee().force_W);
}

TEST(RandomForceTest, IsUniformInLegMagnitudeAndDirectionAndHeldForAPeriod) {
  TestRig<RandomForce> rig(RandomForceParams{DogBot(), false, 10, 35, Hz(0.5)});
  const int n = 4000;
  std::array<int, kNumLegs> legs{};
  int thighs = 0;
  Vec<3> direction = Vec<3>::Zero(), direction_squares = Vec<3>::Zero();
  double magnitude = 0;
  for (int i = 0; i < n; ++i) {
    const ExternalForce force = rig.Tick()[rig->force];
    const double size = force.force_W.norm();
    EXPECT_GE(size, 10 - 1e-12);
    EXPECT_LT(size, 35);
    ++legs.at(static_cast<std::size_t>((force.body - 1) / kJointsPerLeg));
    thighs += (force.body - 1) % kJointsPerLeg == 1 ? 1 : 0;
    magnitude += size / n;
    direction += force.force_W / size / n;
    direction_squares += (force.force_W / size).cwiseAbs2() / n;
  }
  // 4 standard deviations of n uniform choices.
  for (const int count : legs) EXPECT_NEAR(count, n / 4, 4 * std::sqrt(n * 0.25 * 0.75));
  EXPECT_NEAR(thighs, n / 2, 4 * std::sqrt(n * 0.25));
  EXPECT_NEAR(magnitude, 22.5, 4 * 25 / std::sqrt(12.0 * n));
  EXPECT_THAT(direction, IsNear(Vec<3>::Zero(), 4 * std::sqrt(1.0 / 3 / n)));
  EXPECT_THAT(direction_squares, IsNear(Vec<3>::Constant(1.0 / 3), 4 * std::sqrt(4.0 / 45 / n)));

  const ExternalForce held = rig[rig->force];
  rig.RunTo(rig.time() + 1.9);
  EXPECT_EQ(rig[rig->force].force_W, held.force_W);
  EXPECT_NE(rig.Tick()[rig->force].force_W, held.force_W);
}

TEST(RandomForceTest, OnTheTrunkActsAtItsOrigin) {
  TestRig<RandomForce> rig(RandomForceParams{DogBot(), true, 10, 35, Hz(0.5)});
  const ExternalForce& force = rig.Tick()[rig->force];
  EXPECT_EQ(force.body, 0);
  EXPECT_EQ(force.p_B, Vec<3>::Zero());
  EXPECT_GE(force.force_W.norm(), 10);
}

TEST(ForceBundleTest, PutsForcesSideBySide) {
  TestRig<ForceBundle> rig(ForceBundleParams{2});
  ExternalForce other = OnKnee();
  other.body = 0;
  rig.Fix(rig->force[0], OnKnee()).Fix(rig->force[1], other);
  const ExternalForces& forces = rig[rig->forces];
  EXPECT_EQ(forces[0].body, 3);
  EXPECT_EQ(forces[1].body, 0);
  EXPECT_EQ(forces[1].force_W, other.force_W);
  EXPECT_TRUE(forces[2].force_W.isZero(0));
}

// In free fall without gravity the change of angular momentum is the torque, that of momentum the force.
TEST(ExternalForceTest, TorqueOnTheTrunkTurnsTheRobot) {
  QuadrupedPlantParams params{.robot = DogBot(), .gravity = 0};
  params.initial = test::Standing(params.robot);
  params.initial.p_WB[2] = 2;
  TestRig<QuadrupedPlant> rig(params);
  ExternalForces forces;
  forces[0].torque_W = {3, -2, 5};
  rig.Fix(rig->torque, Vec<12>::Zero()).Fix(rig->external, forces);
  const LeggedAcceleration& acceleration = rig[rig->acceleration];
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(params.robot, 0), params.initial);
  const Vec<18> rates = test::Stacked(acceleration);
  EXPECT_THAT(Vec<3>(dynamics.angular_map * rates), IsNear(Vec<3>(3, -2, 5), 1e-9));
  EXPECT_THAT(Vec<3>(dynamics.M.topRows<3>() * rates), IsNear(Vec<3>(0, 0, 0), 1e-9));
}

TEST(DisturbancesTest, RefuseParametersThatMakeNoSense) {
  ExternalForce no_body = OnKnee(), not_finite = OnKnee();
  no_body.body = 13;
  not_finite.force_W[1] = NAN;
  EXPECT_TRUE(Refuses<PulseForce>({no_body, 0, 1}, "body 13"));
  EXPECT_TRUE(Refuses<SineForce>({not_finite, 1}, "force"));
  EXPECT_TRUE(Refuses<SineForce>({OnKnee(), 1, 2, 1}, "1 s", "2 s"));
  EXPECT_TRUE(Refuses<RandomForce>({DogBot(), false, 3, 2}, "3", "2 N"));
  EXPECT_TRUE(Refuses<RandomForce>({{}, false, 1, 2}, "robot"));
  EXPECT_TRUE(Refuses<ForceBundle>({9}, "9"));
}

TEST(DisturbancesTest, ForcesAreSetInARun) {
  TestRig<SineForce> sine, built_sine(SineForceParams{OnKnee(), 2.0, 0.5, 4.0});
  sine.Set(sine->amplitude, OnKnee()).Set(sine->angular_frequency, 2).Set(sine->start, 0.5).Set(sine->end, 4);
  for (const double time : {0.2, 1.0, 5.0})
    EXPECT_EQ(sine.RunTo(time)[sine->force].force_W, built_sine.RunTo(time)[built_sine->force].force_W);
  EXPECT_TRUE(Throws<ParameterError>([&] { sine.Set(sine->end, 0); }, "0 s", "0.5 s"));

  TestRig<PulseForce> pulse;
  pulse.Set(pulse->push, OnKnee()).Set(pulse->start, 1).Set(pulse->duration, 0.5);
  EXPECT_EQ(pulse.RunTo(0.999)[pulse->force].force_W, Vec<3>(0, 0, 0));
  EXPECT_EQ(pulse.RunTo(1)[pulse->force].force_W, OnKnee().force_W);
  EXPECT_EQ(pulse.RunTo(1.5)[pulse->force].force_W, Vec<3>(0, 0, 0));

  TestRig<RandomForce> random(RandomForceParams{.robot = DogBot(), .upper = 1});
  random.context().Set(random->lower, 7.0, random->upper, 8.0, random->on_trunk, true);
  random.Tick();
  EXPECT_GT(random[random->force].force_W.norm(), 6.9);
  EXPECT_EQ(random[random->force].body, 0);
  EXPECT_TRUE(Throws<ParameterError>([&] { random.Set(random->lower, 9); }, "9", "8 N"));
}

LeggedState After(const LeggedState& x, double dt) {
  LeggedState next = x;
  next.p_WB += dt * x.v_W;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(dt * x.w_W.norm(), x.w_W.normalized()).toRotationMatrix() * x.R_WB();
  next.q_WB = QuaternionFromRotation(R);
  next.q += dt * x.qd;
  return next;
}

// Positions from Simbody, velocities from their differences in time.
TEST(SpringPullTest, ComputesPositionsAndVelocitiesOfPoints) {
  const QuadrupedDescription robot = test::SkewDogBot();
  RandomStream random(1);
  for (int body = 0; body <= kNumJoints; ++body) {
    const LeggedState x = test::RandomState(random);
    const Vec<3> p_B = test::RandomVector<3>(random, 0.2);
    QuadrupedBody bodies(robot);
    const auto place = [&](double dt) {
      bodies.SetState(After(x, dt));
      return bodies.Position(body, p_B);
    };
    const BodyPoint point = PointOfBody(robot, x, body, p_B);
    EXPECT_THAT(point.p_W, IsNear(place(0), 1e-12)) << body;
    EXPECT_THAT(point.v_W, IsNear(Vec<3>((place(1e-5) - place(-1e-5)) / 2e-5), 1e-8)) << body;
    EXPECT_THAT(PointInBody(robot, x, body, point.p_W), IsNear(p_B, 1e-12)) << body;
  }
}

TEST(SpringPullTest, PullsByHooksLawUpToItsLargestForce) {
  TestRig<SpringPull> rig(
      SpringPullParams{.robot = test::DogBot(), .stiffness = 100, .damping = 10, .max_force = 50});
  rig.Fix(rig->state, {.p_WB = {1, 2, 0.5}, .v_W = {0, 0.5, 0}});
  EXPECT_TRUE(rig[rig->force].force_W.isZero(0));
  rig.Set(rig->grip, {true, 0, {0.1, 0, 0}, {1.1, 2, 0.8}});
  EXPECT_EQ(rig[rig->force].body, 0);
  EXPECT_THAT(rig[rig->force].p_B, IsNear(Vec<3>(0.1, 0, 0), 0));
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, -5, 30), 1e-12));
  rig.Set(rig->grip, {true, 0, {0.1, 0, 0}, {1.1, 2.05, 9}});
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, 50), 1e-12));
}

TEST(SpringPullTest, ItsDefaultsFollowFromTheRobotsWeight) {
  const QuadrupedDescription robot = test::DogBot();
  TestRig<SpringPull> rig(SpringPullParams{.robot = robot});
  EXPECT_NEAR(rig->params.max_force, 9.81 * robot.mass(), 1e-9);
  EXPECT_NEAR(0.25 * rig->params.stiffness, 9.81 * robot.mass() / 2, 1e-9);
}

TEST(SpringPullTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<SpringPull>({}, "robot"));
  EXPECT_TRUE(Refuses<SpringPull>({.robot = test::DogBot(), .damping = -1}, "-1 N s/m"));
  TestRig<SpringPull> rig(SpringPullParams{.robot = test::DogBot()});
  rig.Fix(rig->state, LeggedState());
  rig.Set(rig->grip, {true, 13, Vec<3>::Zero(), Vec<3>::Zero()});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->force]; }, "body 13"));
}

using test::DogBot, test::Standing;

TEST(JointLockTest, HoldsWhereTheJointsAreWhenItBegins) {
  TestRig<JointLock> rig({.joints = {2, 7}, .schedule = {.start = 0.001, .duration = 0.002}});
  LeggedState x;
  const auto tick = [&](double q) {
    x.q.setConstant(q);
    return rig.Fix(rig->state, x).Tick()[rig->locks];
  };
  EXPECT_TRUE(tick(1).stiffness.isZero(0));
  for (const double q : {2.0, 3.0}) {
    const JointLocks locks = tick(q);
    for (int j = 0; j < kNumJoints; ++j) {
      EXPECT_EQ(locks.stiffness[j], j == 2 || j == 7 ? 5000 : 0);
      EXPECT_EQ(locks.damping[j], j == 2 || j == 7 ? 20 : 0);
      EXPECT_EQ(locks.angle[j], j == 2 || j == 7 ? 2 : 0);
    }
  }
  EXPECT_TRUE(tick(4).stiffness.isZero(0));
  EXPECT_FALSE(rig[rig->acting]);
}

TEST(JointLockTest, ActsOnAConditionAndBesideOthers) {
  TestRig<JointLock> rig({.joints = {0}});
  LeggedState x;
  JointLocks others;
  others.stiffness[5] = 7;
  rig.Fix(rig->state, x).Fix(rig->others, others).Fix(rig->active, false).Tick();
  EXPECT_TRUE(rig[rig->locks].stiffness[0] == 0 && rig[rig->locks].stiffness[5] == 7);
  x.q[0] = 0.3;
  rig.Fix(rig->state, x).Fix(rig->active, true).Tick();
  EXPECT_TRUE(rig[rig->locks].stiffness[0] == 5000 && rig[rig->locks].stiffness[5] == 7);
  EXPECT_EQ(rig[rig->locks].angle[0], 0.3);
}

/// A robot that floats 100 m above the ground, with joint 4 driven by `torque` [N m].
struct Falling {
  explicit Falling(double torque, const JointLockParams& params, bool lossless = false) {
    QuadrupedDescription robot = DogBot();
    if (lossless) robot.drive.damping = robot.drive.friction = 0;
    QuadrupedPlantParams plant_params{.robot = robot, .initial = Standing(robot), .gravity = 0};
    plant_params.initial.p_WB[2] = 100;
    DiagramBuilder builder;
    plant = &builder.Add<QuadrupedPlant>("plant", plant_params);
    lock = &builder.Add<JointLock>("lock", params);
    auto& drives = builder.Add<ConstantSource<Vec<12>>>(
        "drives", ConstantParams<Vec<12>>{.value = torque * Vec<12>::Unit(4), .unit = "N m"});
    builder.Connect(drives.y, plant->torque);
    builder.Connect(plant->state, lock->state);
    builder.Connect(lock->locks, plant->locks);
    simulator.emplace(builder.Build(), SimulatorOptions{.rtol = 1e-6, .atol = 1e-8});
  }
  LeggedState At(double t) {
    simulator->RunTo(t);
    return simulator->context().Eval(plant->state);
  }
  QuadrupedPlant* plant;
  JointLock* lock;
  std::optional<Simulator> simulator;
};

// 20 N m deflect a lock of 5000 N m/rad by 4 mrad in equilibrium, and by twice that at most on the way there;
// without the lock the joint swings away.
TEST(JointLockTest, HoldsAJointAgainstItsDrive) {
  Falling robot(20, {.joints = {4}});
  const double start = robot.At(0).q[4];
  double furthest = 0;
  for (double t = 0.002; t < 0.15; t += 0.002)
    furthest = std::max(furthest, std::abs(robot.At(t).q[4] - start));
  EXPECT_LT(furthest, 0.008);
  EXPECT_GT(furthest, 0.003);
  Falling free(20, {.joints = {4}, .schedule = {.start = 100}});
  EXPECT_GT(std::abs(free.At(0.15).q[4] - start), 0.1);
}

// Energy of the motion and of the lock's spring never grows, and the damper takes it.
TEST(JointLockTest, TakesEnergyAndGivesNone) {
  Falling robot(0, {.joints = {3, 4, 5}}, true);
  LeggedState x = robot.At(0);
  const Vec<12> start = x.q;
  x.qd.segment<3>(3) = Vec<3>(0, 2, -2);
  robot.simulator->context().Set(robot.plant->motion, x);
  const auto energy = [&](double t) {
    const LeggedState now = robot.At(t);
    return robot.simulator->context().Eval(robot.plant->energy).kinetic +
           0.5 * 5000 * (now.q - start).segment<3>(3).squaredNorm();
  };
  const double before = energy(1e-4);
  double last = before;
  for (double t = 0.005; t < 0.1; t += 0.005) {
    const double now = energy(t);
    EXPECT_LE(now, last * (1 + 1e-4)) << t;
    last = now;
  }
  EXPECT_LT((robot.At(0.1).q - start).segment<3>(3).norm(), 1e-3);
  EXPECT_LT(last, 0.9 * before);
}

TEST(JointLockTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<JointLock>({.joints = {12}}, "joint 12"));
  EXPECT_TRUE(Refuses<JointLock>({.stiffness = 0}, "stiffness"));
  EXPECT_TRUE(Refuses<JointLock>({.damping = -1}, "damping"));
}

TEST(DriveErrorsTest, WithoutErrorsItPassesItsInput) {
  TestRig<DriveErrors> rig;
  const Vec<12> command = Vec<12>::LinSpaced(-6, 5);
  rig.Fix(rig->command, command).Tick();
  EXPECT_EQ(rig[rig->torque], command);
}

TEST(DriveErrorsTest, EachDriveHasAConstantThatStays) {
  TestRig<DriveErrors> rig(DriveErrorsParams{.gain_deviation = 0.1});
  rig.Fix(rig->command, Vec<12>::Constant(10)).Tick();
  const Vec<12> first = rig[rig->torque];
  EXPECT_GT((first.array() - first.mean()).abs().minCoeff(), 0) << "no two alike";
  rig.Fix(rig->command, Vec<12>::Constant(20)).Tick();
  EXPECT_NEAR((rig[rig->torque] - 2 * first).norm(), 0, 1e-12);
}

TEST(DriveErrorsTest, RippleGrowsWithTheTorque) {
  constexpr int kTicks = 5000;
  TestRig<DriveErrors> rig(DriveErrorsParams{.ripple = 0.05});
  const Vec<12> command = Vec<12>::LinSpaced(0, 33);
  rig.Fix(rig->command, command);
  Vec<12> squares = Vec<12>::Zero();
  for (int n = 0; n < kTicks; ++n) squares += (rig.Tick()[rig->torque] - command).cwiseAbs2() / kTicks;
  for (int j = 0; j < 12; ++j) EXPECT_NEAR(std::sqrt(squares[j]), 0.05 * command[j], 0.003 * command[j]) << j;
}

}  // namespace tenon::disturbances_test
