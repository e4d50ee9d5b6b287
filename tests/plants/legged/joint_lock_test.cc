#include <tenon/plants/legged/drive_errors.h>
#include <tenon/plants/legged/joint_lock.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::joint_lock_test {

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

}  // namespace tenon::joint_lock_test
