#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::com_planner_test {

const GaitTiming kTrot{.num_steps = 2, .step = {0, 1, 1, 0}, .stance = 0.15, .swing = 0.115};
const GaitTiming kPace{.num_steps = 2, .step = {0, 1, 0, 1}, .stance = 0.15, .swing = 0.115};
const GaitTiming kCrawl{.num_steps = 4, .step = {1, 3, 0, 2}, .stance = 0.05, .swing = 0.2};

ComPlannerParams Params() {
  return {.robot = test::DogBot()};
}

/// The planner, fed with the schedule of an undisturbed walk.
class Walk {
 public:
  explicit Walk(const ComPlannerParams& params = Params()) : rig_(params) { Change(Gait::kStand, {}); }
  /// A new gait begins at the next tick.
  void Change(Gait gait, const GaitTiming& timing) {
    schedule_.gait = gait;
    schedule_.timing = timing;
    schedule_.step = 0;
    if (ticks_ > 0) ++schedule_.footsteps;
    step_ticks_ = 0;
  }
  void Command(double forward, double left, double yaw_rate) {
    command_.forward = forward;
    command_.left = left;
    command_.yaw_rate = yaw_rate;
  }
  GroundPlane& ground() { return ground_; }
  /// Stops or continues the gait clock.
  void Wait(bool waits) { waits_ = waits; }

  const BodyReference& Tick() {
    const double duration = schedule_.timing.step_duration();
    if (schedule_.timing.num_steps > 0 && step_ticks_ > 0 && step_ticks_ >= std::lround(1000 * duration) &&
        !waits_) {
      schedule_.step = (schedule_.step + 1) % schedule_.timing.num_steps;
      ++schedule_.footsteps;
      step_ticks_ = 0;
    }
    schedule_.step_time = std::min(duration, 1e-3 * static_cast<double>(step_ticks_++));
    ++ticks_;
    rig_.Fix(rig_->schedule, schedule_).Fix(rig_->command, command_);
    rig_.Fix(rig_->ground, ground_).Tick();
    return reference_ = rig_[rig_->reference];
  }
  void Run(double seconds) {
    for (int n = 0; n < std::lround(1000 * seconds); ++n) Tick();
  }
  const BodyReference& reference() const { return reference_; }
  const PlanarPath& path() { return rig_[rig_->path]; }
  const ComPlan& plan() { return rig_[rig_->plan]; }
  const ContactSchedule& schedule() const { return schedule_; }
  const NominalStance& stance() { return rig_->stance; }
  TestRig<ComPlanner>& rig() { return rig_; }
  /// (2.4) and (2.5) with L' = 0.
  Eigen::Vector2d Zmp() {
    const double height = stance().com_height;
    return reference_.com_W.head<2>() - height / 9.81 * reference_.com_acceleration_W.head<2>();
  }

 private:
  TestRig<ComPlanner> rig_;
  GroundPlane ground_;
  ContactSchedule schedule_;
  WalkCommand command_;
  BodyReference reference_;
  long step_ticks_ = 0, ticks_ = 0;
  bool waits_ = false;
};

TEST(NominalStanceTest, IsTheRobotsOwn) {
  const NominalStance stance(test::DogBot());
  EXPECT_NEAR(stance.com_height, 0.395, 0.01);
  EXPECT_THAT(stance.foot[kFrontLeft], IsNear(-stance.foot[kRearRight], 1e-9));
  EXPECT_GT(stance.foot[kFrontLeft][0], 0.2);
  EXPECT_GT(stance.foot[kFrontLeft][1], 0.1);
  // With the foot moved outwards by the reach, the leg is stretched to 95 %.
  const QuadrupedDescription robot = test::DogBot();
  const auto& leg = robot.legs[kFrontLeft];
  const Eigen::Vector3d hip = leg.joints[0].p_PJ + leg.joints[1].p_PJ;
  const Eigen::Vector3d foot = robot.FootPosition(kFrontLeft, robot.stance) - hip;
  const double radius = foot.head<2>().norm() + stance.reach[kFrontLeft];
  EXPECT_NEAR(std::hypot(radius, foot[2]), 0.95 * (leg.joints[2].p_PJ.norm() + leg.foot_J.norm()), 1e-9);
}

TEST(NominalStanceTest, RefusesStraightLegs) {
  QuadrupedDescription robot = test::DogBot();
  robot.stance.setZero();
  EXPECT_TRUE(Throws<ParameterError>([&] { NominalStance stance(robot); }, "front_left", "dogbot"));
}

TEST(ComPlannerTest, StandsOverTheCenterOfTheFeet) {
  ComPlannerParams params = Params();
  params.start_position << 3, -1;
  params.start_yaw = 0.5;
  Walk walk(params);
  walk.Tick();
  const Eigen::Rotation2Dd R(0.5);
  const NominalStance& stance = walk.stance();
  EXPECT_THAT(walk.reference().com_W.head<2>(),
              IsNear(params.start_position + R * stance.com_B.head<2>(), 1e-12));
  walk.Run(0.6);
  EXPECT_THAT(walk.reference().com_W.head<2>(), IsNear(params.start_position + R * stance.center_B, 1e-12));
  EXPECT_NEAR(walk.reference().com_W[2], stance.com_height, 1e-6);
  EXPECT_EQ(walk.reference().com_velocity_W.norm(), 0);
  EXPECT_THAT(walk.reference().q_WB, IsNear(Vec<4>(std::cos(0.25), 0, 0, std::sin(0.25)), 1e-15));
}

// In the middle of the swing the ZMP is on the path in a trot, and beside it, between the standing feet, in a
// pace.
TEST(ComPlannerTest, ZmpIsOnTheLineOfTheStandingFeet) {
  for (const Gait gait : {Gait::kTrot, Gait::kPace}) {
    Walk walk;
    walk.Tick();
    walk.Change(gait, gait == Gait::kTrot ? kTrot : kPace);
    gait == Gait::kTrot ? walk.Command(0.3, 0.05, 0.2) : walk.Command(0.2, 0, 0);
    walk.Run(15 * 0.53);
    for (int n = 0; n < 530; ++n) {
      walk.Tick();
      const double t = walk.schedule().step_time;
      if (t < 0.151 || t > 0.264) continue;
      const double beside = walk.stance().foot[walk.schedule().step == 0 ? kFrontRight : kFrontLeft][1];
      const Eigen::Vector2d offset(0, gait == Gait::kTrot ? 0 : beside);
      EXPECT_THAT(walk.Zmp(), IsNear(walk.path().At(0.2075 - t).position_W + offset, 1e-6)) << t;
    }
  }
}

TEST(ComPlannerTest, ZmpOfACrawlIsTheCenterOfThreeFeet) {
  Walk walk;
  walk.Tick();
  walk.Change(Gait::kCrawl, kCrawl);
  walk.Run(15);
  const Eigen::Vector2d center = walk.path().position_W;
  for (int n = 0; n < 1000; ++n) {
    walk.Tick();
    const double t = walk.schedule().step_time;
    if (t < 0.051 || t > 0.249) continue;
    const int swing[] = {kRearLeft, kFrontLeft, kRearRight, kFrontRight};
    const auto leg = static_cast<std::size_t>(swing[walk.schedule().step]);
    EXPECT_THAT(walk.Zmp() - center, IsNear(-walk.stance().foot[leg] / 3, 1e-6)) << t;
  }
}

TEST(ComPlannerTest, APlanThatRepeatsTheOldOneChangesNothing) {
  Walk walk;
  walk.Tick();
  walk.Change(Gait::kCrawl, kCrawl);
  walk.Command(0.12, 0, 0.1);
  walk.Run(1.001);
  EXPECT_GT(walk.plan().remainder[0].norm(), 1e-4);
  walk.Run(15);
  EXPECT_LT(walk.plan().remainder[0].norm(), 1e-7);
}

/// From one tick to the next the CoM moves by its velocity, and this changes by a bounded acceleration.
void ExpectIntegrals(const BodyReference& last, const BodyReference& now, int n) {
  const double dt = 1e-3;
  EXPECT_THAT(now.com_W - last.com_W, IsNear(dt / 2 * (now.com_velocity_W + last.com_velocity_W), 3e-6)) << n;
  EXPECT_THAT(now.com_velocity_W - last.com_velocity_W,
              IsNear(dt / 2 * (now.com_acceleration_W + last.com_acceleration_W), 4e-3))
      << n;
}

/// For all commands, positions are integrals of velocities and velocities of bounded accelerations.
TEST(ComPlannerTest, NothingJumps) {
  Walk walk;
  BodyReference last = walk.Tick();
  const double dt = 1e-3;
  double largest = 0;
  for (int n = 1; n < 9000; ++n) {
    if (n == 300) walk.Change(Gait::kTrot, kTrot);
    if (n == 400) walk.Command(0.1, 0.02, 0.3);
    if (n == 2050) walk.Change(Gait::kPace, kPace);
    if (n == 3100) walk.Wait(true);  // for 0.3 s and more
    if (n == 3600) walk.Wait(false);
    if (n == 4500) walk.Change(Gait::kCrawl, kCrawl);
    if (n == 6010) walk.ground().p_W[2] += 0.03;
    if (n == 8000) walk.Change(Gait::kStand, {});
    const BodyReference now = walk.Tick();
    ExpectIntegrals(last, now, n);
    largest = std::max(largest, now.com_acceleration_W.norm());
    const double turn = 2 * (std::atan2(now.q_WB[3], now.q_WB[0]) - std::atan2(last.q_WB[3], last.q_WB[0]));
    EXPECT_NEAR(turn, dt / 2 * (now.w_W[2] + last.w_W[2]), 1e-6) << n;
    EXPECT_NEAR(now.w_W[2] - last.w_W[2], dt / 2 * (now.alpha_W[2] + last.alpha_W[2]), 4e-3) << n;
    last = now;
  }
  EXPECT_LT(largest, 5);
  EXPECT_EQ(last.com_velocity_W.norm(), 0);
  EXPECT_NEAR(last.com_W[2], walk.stance().com_height + 0.03, 1e-6);
}

// Up and along a slope the CoM keeps its vertical height above the plane and the trunk is parallel to it,
// without a jump when the slope changes.
TEST(ComPlannerTest, GoesAlongTheSlope) {
  Walk walk;
  walk.Tick();
  walk.Change(Gait::kTrot, kTrot);
  walk.Command(0.2, 0, 0.5);
  BodyReference last = walk.Tick();
  const double dt = 1e-3;
  for (int n = 0; n < 4000; ++n) {
    if (n == 1000) walk.ground().slope << 0.3, -0.2;
    const BodyReference now = walk.Tick();
    ExpectIntegrals(last, now, n);
    const Eigen::Matrix3d R = RotationFromQuaternion(now.q_WB), R_last = RotationFromQuaternion(last.q_WB);
    const Eigen::AngleAxisd turn(R * R_last.transpose());
    EXPECT_THAT(turn.angle() * turn.axis(), IsNear(dt / 2 * (now.w_W + last.w_W), 1e-5)) << n;
    last = now;
  }
  EXPECT_NEAR(last.com_W[2], walk.ground().HeightAt(last.com_W.head<2>()) + walk.stance().com_height, 1e-7);
  EXPECT_NEAR(last.com_velocity_W[2], walk.ground().slope.dot(last.com_velocity_W.head<2>()), 1e-6);
  const Eigen::Matrix3d R = RotationFromQuaternion(last.q_WB);
  EXPECT_THAT(R.col(2), IsNear(walk.ground().Normal(), 1e-6));
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), walk.path().yaw, 1e-7);
}

TEST(ComPlannerTest, CommandsCountFromTheNextFootstep) {
  Walk walk, commanded;
  for (Walk* w : {&walk, &commanded}) {
    w->Tick();
    w->Change(Gait::kTrot, kTrot);
    w->Run(0.1);
  }
  commanded.Command(0.3, 0, 0.4);
  walk.Run(0.165);
  commanded.Run(0.165);
  EXPECT_EQ(walk.reference().com_W, commanded.reference().com_W);
  EXPECT_EQ(commanded.path().velocity[0], 0);
  commanded.Tick();
  EXPECT_EQ(commanded.path().velocity[0], 0.3);
}

TEST(ComPlannerTest, PathIsTheCircleThatIsCommanded) {
  Walk walk;
  walk.Tick();
  walk.Change(Gait::kTrot, kTrot);
  walk.Command(0.12, 0, 0.05);
  walk.Tick();
  const Eigen::Vector2d begin = walk.path().position_W;
  walk.Run(20);
  const double radius = 0.12 / 0.05, angle = 0.05 * 20;
  EXPECT_THAT(walk.path().position_W - begin,
              IsNear(radius * Eigen::Vector2d(std::sin(angle), 1 - std::cos(angle)), 1e-9));
  EXPECT_NEAR(walk.path().yaw, angle, 1e-12);
  walk.Change(Gait::kStand, {});
  walk.Tick();
  EXPECT_EQ(walk.path().velocity.norm(), 0);
  EXPECT_EQ(walk.path().yaw_rate, 0);
}

TEST(ComPlannerTest, RefusesNonsense) {
  ComPlannerParams params = Params();
  params.gravity = 0;
  EXPECT_TRUE(Refuses<ComPlanner>(params, "gravity"));
}

using test::DogBot;

/// DogBot with another range of the front left knee.
QuadrupedDescription WithKneeRange(double lower, double upper) {
  QuadrupedDescription robot = DogBot();
  JointDescription& knee = robot.legs[kFrontLeft].joints[2];
  knee.lower = lower;
  knee.upper = upper;
  return robot;
}

/// Distance from hip to foot of the front left leg with the knee at this angle.
double Extension(const QuadrupedDescription& robot, double knee) {
  Vec<12> q = robot.stance;
  q[2] = knee;
  return (robot.FootPosition(kFrontLeft, q) - robot.HipPosition(kFrontLeft, q)).norm();
}

TEST(NominalStance, AKneeThatCanStraightenExtendsTheWholeLeg) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double end : {0.5, 3.0, kInfinity}) {
    const QuadrupedDescription robot = WithKneeRange(-end, end);
    EXPECT_EQ(robot.LongestExtension(kFrontLeft), robot.LegLength(kFrontLeft)) << end;
    EXPECT_DOUBLE_EQ(NominalStance(robot).longest[kFrontLeft], 0.95 * robot.LegLength(kFrontLeft));
  }
}

// The longest extension is that at the end of the range which is closer to a straight knee, also if the range
// is given a turn away.
TEST(NominalStance, TheRangeOfTheKneeLimitsTheReach) {
  for (const double turn : {0.0, 6.283185307179586}) {
    for (const bool backward : {true, false}) {
      const QuadrupedDescription robot =
          backward ? WithKneeRange(-2.5 + turn, -0.9 + turn) : WithKneeRange(0.9 + turn, 2.5 + turn);
      const double longest = robot.LongestExtension(kFrontLeft);
      EXPECT_NEAR(longest, Extension(robot, backward ? -0.9 : 0.9), 1e-12);
      EXPECT_GT(longest, Extension(robot, backward ? -1.0 : 1.0));
      EXPECT_LT(NominalStance(robot).longest[kFrontLeft], longest);
      EXPECT_LT(NominalStance(robot).reach[kFrontLeft], NominalStance(DogBot()).reach[kFrontLeft]);
    }
  }
}

}  // namespace tenon::com_planner_test
