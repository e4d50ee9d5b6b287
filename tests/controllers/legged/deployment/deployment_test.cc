#include <tenon/controllers/legged/deployment/deployment.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <set>

namespace tenon::deployment_test {
namespace {

using enum DeploymentMode;
using Goal = DeploymentGoal;
using Fault = DeploymentFault;

const QuadrupedDescription& Go2() {
  static const auto kRobot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
  return kRobot;
}

/// A supervisor of a Go2 whose joints follow the commands, with some noise.
class Robot {
 public:
  explicit Robot(DeploymentMode initial) : rig_(DeploymentParams{.robot = Go2(), .initial = initial}) {
    joints_.q = initial == kPassive ? LyingPosture(Go2()) : Go2().stance;
    for (int j = 0; j < kNumJoints; ++j) {
      limit_[j] = Go2().joint(j).torque_limit;
      speed_limit_[j] = Go2().joint(j).speed_limit;
    }
    Ask(Goal::kWalk);
    Fix(Vec<12>::Zero());
    Measure(joints_, state_);
  }
  void Ask(Goal goal) { rig_.Fix(rig_->goal, goal); }
  void Fix(const Vec<12>& torque) { rig_.Fix(rig_->torque, torque); }
  void Measure(const JointMotion& joints, const LeggedState& state) {
    rig_.Fix(rig_->joints, joints).Fix(rig_->state, state);
    measured_ = joints;
  }
  void Beat(double time) { rig_.Fix(rig_->heartbeat, time); }
  /// A tick with a new state of the robot.
  DeploymentMode Live() {
    joints_.q[0] += 1e-6 * random_.Uniform(-1, 1);
    state_.w_W[0] = 1e-3 * random_.Normal();
    Beat(beat_ += 0.001);
    Measure(joints_, state_);
    return Tick();
  }
  DeploymentMode Tick() {
    const JointCommand& command = rig_.Tick()[rig_->command];
    joints_.q += command.kp.cwiseMin(1).cwiseProduct(command.q - joints_.q);
    return status().mode;
  }
  /// Ticks until the mode is another, with its number; at most `most`.
  int Until(DeploymentMode mode, int most = 10'000) {
    int ticks = 1;
    while (Live() != mode && ticks < most) ++ticks;
    return ticks;
  }
  /// A run that begins anew.
  void Restart(DeploymentMode mode) {
    DeploymentStatus memory;
    memory.mode = mode;
    memory.from = Go2().stance;
    memory.heartbeat = beat_;
    memory.stiff = memory.walking = random_.Uniform(0, 1);
    rig_.Set(rig_->memory, memory);
    joints_.q = Go2().stance;
  }
  bool damps() {
    const JointCommand& c = command();
    return c.kp.isZero(0) && c.torque.isZero(0) && c.qd.isZero(0) && c.kd.minCoeff() > 0;
  }
  const DeploymentStatus& status() { return rig_[rig_->status]; }
  const JointCommand& command() { return rig_[rig_->command]; }
  /// The largest torque of the command over the limit, at the measured joints and, damped, at any speed.
  double LargestTorqueRatio() {
    const Vec<12> now = command().TorqueAt(measured_).cwiseAbs().cwiseQuotient(limit_);
    const Vec<12> damped = command().kd.cwiseProduct(speed_limit_).cwiseQuotient(limit_);
    const bool possible = (measured_.qd.cwiseAbs() - speed_limit_).maxCoeff() <= 0;
    return std::max(possible ? now.maxCoeff() : 0.0, status().mode == kDamp ? damped.maxCoeff() : 0.0);
  }
  double beat() const { return beat_; }
  const Vec<12>& limit() const { return limit_; }
  JointMotion joints_;
  LeggedState state_;
  RandomStream random_{7, "robot"};

 private:
  TestRig<Deployment> rig_;
  JointMotion measured_;
  Vec<12> limit_, speed_limit_;
  double beat_ = 0;
};

TEST(DeploymentTransitionsTest, AFaultDampsInEveryModeWithTorque) {
  std::set<DeploymentMode> seen, reached;
  for (const DeploymentTransition& row : DeploymentTransitions()) {
    const bool first = seen.insert(row.from).second;
    reached.insert(row.to);
    const bool idle = row.from == kPassive || row.from == kDamp;
    if (first && !idle) EXPECT_EQ(row.event, &DeploymentEvents::fault) << EnumName(row.from);
    if (row.from == kDamp) EXPECT_EQ(row.to, kPassive);
    EXPECT_THAT(DeploymentGraph(), ::testing::HasSubstr(std::string(EnumName(row.from)) + " -> " +
                                                        EnumName(row.to) + " [label=\"" + row.name));
  }
  EXPECT_EQ(seen.size(), 6u);
  EXPECT_EQ(reached.size(), 6u);
  EXPECT_EQ(NextDeploymentMode(kWalk, {.fault = true, .halt = true}), kDamp) << "the first row counts";
  EXPECT_EQ(NextDeploymentMode(kWalk, {}), kWalk);
}

TEST(DeploymentTest, RisesWalksAndLiesDown) {
  Robot robot(kPassive);
  robot.Ask(Goal::kLie);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(robot.Live(), kPassive);
  EXPECT_TRUE(robot.command().kp.isZero(0) && robot.command().kd.isZero(0));
  robot.Ask(Goal::kWalk);
  EXPECT_EQ(robot.Live(), kStandUp);
  EXPECT_LT(robot.command().kp[0], 0.01 * 60) << "the stiffness rises from 0";
  EXPECT_EQ(robot.Until(kStand), 2000);
  EXPECT_LT((robot.command().q - Go2().stance).norm(), 1e-4);
  EXPECT_EQ(robot.Live(), kWalk);
  robot.Fix(0.1 * robot.limit());
  for (int i = 0; i < 500; ++i) robot.Live();
  EXPECT_LT((robot.command().torque - 0.1 * robot.limit()).norm(), 1e-9);
  EXPECT_TRUE(robot.command().kp.isZero(0)) << "the controller alone";
  robot.Ask(Goal::kLie);
  EXPECT_EQ(robot.Live(), kStand);
  EXPECT_EQ(robot.Live(), kLieDown);
  EXPECT_EQ(robot.Until(kDamp), 2000);
  EXPECT_EQ(robot.Until(kPassive), 2000) << "it sinks to the ground slowly";
  EXPECT_EQ(robot.status().fault, Fault::kNone);
  EXPECT_LT((robot.joints_.q - LyingPosture(Go2())).norm(), 1e-3);
}

TEST(DeploymentTest, LiesWithFoldedLegsBelowTheHips) {
  for (const char* name : {"go2", "b2", "a1", "dogbot", "anymal_c", "solo12", "aliengo"}) {
    const QuadrupedDescription robot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/" + name + ".yaml");
    const Vec<12> lying = LyingPosture(robot);
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Eigen::Vector3d foot = robot.FootPosition(leg, lying),
                            before = robot.FootPosition(leg, robot.stance);
      EXPECT_NEAR(foot[0], before[0], 0.02) << name;
      EXPECT_GT(foot[2], 0.8 * before[2]) << name;
      EXPECT_LT(foot[2], 0) << name;
    }
  }
}

TEST(DeploymentTest, StopsUntilTheOperatorLaysTheRobotDown) {
  Robot robot(kWalk);
  robot.Live();
  robot.Ask(Goal::kStop);
  EXPECT_EQ(robot.Live(), kDamp);
  EXPECT_TRUE(robot.damps());
  EXPECT_EQ(robot.status().fault, Fault::kStop);
  robot.Ask(Goal::kWalk);
  EXPECT_EQ(robot.Until(kPassive), 2000);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(robot.Live(), kPassive) << "until the fault is acknowledged";
  robot.Ask(Goal::kLie);
  robot.Live();
  robot.Ask(Goal::kStand);
  EXPECT_EQ(robot.Live(), kStandUp);
}

TEST(DeploymentTest, EachLimitDampsAtTheTickThatSeesIt) {
  const auto expect = [](Fault fault, auto change) {
    Robot robot(kWalk);
    for (int i = 0; i < 30; ++i) ASSERT_EQ(robot.Live(), kWalk);
    change(robot);
    EXPECT_EQ(robot.Live(), kDamp) << EnumName(fault);
    EXPECT_EQ(robot.status().fault, fault);
    EXPECT_TRUE(robot.damps());
  };
  expect(Fault::kTilt, [](Robot& r) { r.state_.q_WB = QuaternionFromRotationVector({0.81, 0, 0}); });
  expect(Fault::kAngle, [](Robot& r) { r.joints_.q[4] = Go2().joint(4).upper + 0.16; });
  expect(Fault::kSpeed, [](Robot& r) { r.joints_.qd[7] = -1.31 * Go2().joint(7).speed_limit; });
  expect(Fault::kEstimator, [](Robot& r) { r.state_.v_W[1] = 5.1; });
}

TEST(DeploymentTest, KeepsTorquesAndTheirChangesWithinTheLimits) {
  Robot robot(kWalk);
  robot.Fix(10 * robot.limit());
  robot.Live();
  EXPECT_LT((robot.command().torque - 0.5 * robot.limit()).norm(), 1e-9);
  for (int i = 0; i < 5; ++i) robot.Live();
  EXPECT_LT((robot.command().torque - robot.limit()).norm(), 1e-9);
}

// 1,000 faults at random phases of random modes, with a controller that asks for anything. A late tick sees
// the clock of the robot advance by more than 15 ms.
TEST(DeploymentTest, DampsWithin20MillisecondsAtAnyPhase) {
  enum Kind { kSilent, kFrozenValues, kAbsurd, kLate, kButton };
  Robot robot(kWalk);
  RandomStream random(3, "phases");
  std::map<Fault, int> seen;
  const DeploymentMode modes[] = {kStandUp, kStand, kWalk, kLieDown};
  for (int run = 0; run < 1000; ++run) {
    const auto kind = static_cast<Kind>(run % 5);
    const DeploymentMode mode = modes[static_cast<std::size_t>(random.Uniform(0, 3.999))];
    robot.Restart(mode);
    robot.Ask(mode == kWalk ? Goal::kWalk : mode == kLieDown ? Goal::kLie : Goal::kStand);
    const int phase = static_cast<int>(random.Uniform(1, 25));
    const auto tick = [&](bool live) {
      Vec<12> torque;
      for (int j = 0; j < kNumJoints; ++j) torque[j] = random.Uniform(-3, 3) * robot.limit()[j];
      robot.Fix(torque);
      if (live)
        robot.Live();
      else
        robot.Tick();
      ASSERT_LE(robot.LargestTorqueRatio(), 1 + 1e-12) << "run " << run;
    };
    for (int i = 0; i < phase; ++i) tick(true);
    ASSERT_EQ(robot.status().mode, mode) << "run " << run;
    int ticks = 0;
    double beat = robot.beat();
    while (!robot.damps() && ticks < 30) {
      ++ticks;
      if (kind == kFrozenValues) robot.Beat(beat += 1e-3);
      if (kind == kAbsurd) {
        JointMotion joints = robot.joints_;
        joints.qd[run % 12] = 1e300;
        robot.Measure(joints, robot.state_);
      }
      if (kind == kLate) robot.Beat(1e7 + run);
      if (kind == kButton) robot.Ask(Goal::kStop);
      tick(false);
    }
    EXPECT_LE(ticks, 16) << "run " << run;
    ++seen[robot.status().fault];
    for (int i = 0; i < 5; ++i) tick(false);
    EXPECT_TRUE(robot.damps()) << "run " << run;
  }
  for (const Fault fault : {Fault::kLost, Fault::kFrozen, Fault::kSpeed, Fault::kMissed, Fault::kStop})
    EXPECT_EQ(seen[fault], 200) << EnumName(fault);
}

}  // namespace
}  // namespace tenon::deployment_test
