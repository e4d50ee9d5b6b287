#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::legged_state_estimator_test {

using test::A1, test::DogBot, test::RandomVector, test::Standing;

constexpr double kPeriod = 1e-3, kGravity = 9.81;

/// A robot that sways on its feet. The trunk moves in closed form; the joints follow such that every
/// spherical foot rolls on the plane z = 0 without sliding: the velocity of its material point in contact is
/// zero.
class SwayingRobot {
 public:
  explicit SwayingRobot(const QuadrupedDescription& robot, double size = 1)
      : robot_(robot), model_(robot), size_(size), start_(Standing(robot)) {
    q_ = start_.q;
  }

  LeggedState State() const {
    LeggedState x = Trunk(time_);
    x.q = q_;
    x.qd = Speeds(time_, q_);
    return x;
  }
  /// The acceleration of the trunk's origin.
  Vec<3> Acceleration() const {
    const double a = -kSway * kSway * size_, s = std::sin(kSway * time_);
    return a * s * kAmplitude;
  }
  Vec<3> AngularAcceleration() const { return -kTurn * kTurn * size_ * std::sin(kTurn * time_) * kAngle; }
  void Advance() {
    // Runge-Kutta of order 4 on the rolling.
    const double T = kPeriod;
    const Vec<12> k1 = Speeds(time_, q_), k2 = Speeds(time_ + T / 2, q_ + T / 2 * k1),
                  k3 = Speeds(time_ + T / 2, q_ + T / 2 * k2), k4 = Speeds(time_ + T, q_ + T * k3);
    q_ += T / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    time_ += T;
  }
  /// An IMU at a place on the trunk.
  ImuMeasurement Imu(const Vec<3>& p_B = Vec<3>::Zero()) const {
    const LeggedState x = Trunk(time_);
    const Vec<3> arm = x.R_WB() * p_B;
    const Vec<3> a = Acceleration() + AngularAcceleration().cross(arm) + x.w_W.cross(x.w_W.cross(arm));
    const Eigen::Matrix3d R_BW = x.R_WB().transpose();
    return {R_BW * x.w_W, R_BW * (a + Vec<3>(0, 0, kGravity))};
  }

 private:
  static constexpr double kSway = 5, kTurn = 7;  // [rad/s]
  inline static const Vec<3> kAmplitude{0.05, 0.03, 0.02};
  inline static const Vec<3> kAngle{0.06, 0.1, 0.08};

  LeggedState Trunk(double t) const {
    LeggedState x = start_;
    x.p_WB += size_ * std::sin(kSway * t) * kAmplitude;
    x.v_W = size_ * kSway * std::cos(kSway * t) * kAmplitude;
    x.q_WB = QuaternionFromRotationVector(size_ * std::sin(kTurn * t) * kAngle);
    x.w_W = size_ * kTurn * std::cos(kTurn * t) * kAngle;
    return x;
  }
  Vec<12> Speeds(double t, const Vec<12>& q) const {
    LeggedState x = Trunk(t);
    x.q = q;
    const QuadrupedDynamics dynamics = test::DynamicsOf(model_, x);
    Vec<12> speeds;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      Vec<3> contact = dynamics.feet[leg].p_W;
      contact[2] -= robot_.foot_radius;
      const Vec<3> carried = x.v_W + x.w_W.cross(contact - x.p_WB);
      speeds.segment<3>(3 * leg) = -test::Solve(dynamics.LegJacobian(leg, contact), carried);
    }
    return speeds;
  }

  QuadrupedDescription robot_;
  QuadrupedModel model_;
  double size_;
  LeggedState start_;
  Vec<12> q_;
  double time_ = 0;
};

LeggedStateEstimatorParams Params(const SwayingRobot& robot, const QuadrupedDescription& description) {
  LeggedStateEstimatorParams params{.robot = description};
  params.robot.contact.stiffness = 1e12;  // hard ground
  params.robot.contact.blend = 0;
  params.initial = robot.State();
  return params;
}

Vec<3> Normal(RandomStream& random, double deviation) {
  return {deviation * random.Normal(), deviation * random.Normal(), deviation * random.Normal()};
}

/// Rotation vector from b to a, in W.
Vec<3> Turn(const LeggedState& a, const LeggedState& b) {
  const Eigen::AngleAxisd turn(a.R_WB() * b.R_WB().transpose());
  return turn.angle() * turn.axis();
}

ContactSchedule AllStand() {
  return {};
}

using Rig = TestRig<LeggedStateEstimator>;

void Feed(Rig& rig, const ImuMeasurement& imu, const LeggedState& x, const ContactSchedule& schedule) {
  rig.Fix(rig->imu, imu).Fix(rig->joints, {x.q, x.qd}).Fix(rig->schedule, schedule).Tick();
}

TEST(LeggedStateEstimatorTest, StartsInItsInitialState) {
  SwayingRobot robot(DogBot());
  Rig rig(Params(robot, DogBot()));
  const LeggedState x = robot.State();
  Feed(rig, robot.Imu(), x, AllStand());
  const LeggedState& estimate = rig[rig->state];
  EXPECT_THAT(estimate.p_WB, IsNear(x.p_WB, 1e-15));
  EXPECT_THAT(estimate.v_W, IsNear(x.v_W, 1e-15));
  EXPECT_THAT(estimate.w_W, IsNear(x.w_W, 1e-15));
  EXPECT_EQ(estimate.q, x.q);
  EXPECT_EQ(estimate.qd, x.qd);
  EXPECT_EQ(rig[rig->diagnostics].feet, 4);
}

/// The largest error of the velocity in 5 s of a motion in closed form, with perfect sensors [m/s].
double VelocityError(const QuadrupedDescription& description, double foot_radius) {
  SwayingRobot robot(description, 0.7);
  LeggedStateEstimatorParams params = Params(robot, description);
  params.robot.foot_radius = foot_radius;
  params.noise.foot = 1e-5;
  params.noise.foot_walk = 1e-4;
  Rig rig(params);
  double velocity = 0;
  for (int k = 0; k < 5000; ++k, robot.Advance()) {
    const LeggedState x = robot.State();
    Feed(rig, robot.Imu(), x, AllStand());
    const LeggedState& estimate = rig[rig->state];
    velocity = std::max(velocity, (estimate.v_W - x.v_W).norm());
    if (foot_radius != description.foot_radius) continue;
    EXPECT_LT((estimate.p_WB - x.p_WB).norm(), 5e-4) << description.name << k;
    EXPECT_LT(Turn(estimate, x).norm(), 1e-3) << description.name << k;
    EXPECT_LT((estimate.w_W - x.w_W).norm(), 6e-3) << description.name << k;  // one tick old
  }
  EXPECT_EQ(rig[rig->diagnostics].moved_feet, 0);
  return velocity;
}

// The remaining error is half a period of the IMU, whose samples are held. Without the radius of the feet the
// filter would take rolling feet for standing ones.
TEST(LeggedStateEstimatorTest, FollowsAMotionInClosedForm) {
  for (const QuadrupedDescription& robot : {DogBot(), A1()}) {
    const double velocity = VelocityError(robot, robot.foot_radius);
    EXPECT_LT(velocity, 2.5e-3) << robot.name;
    EXPECT_GT(VelocityError(robot, 0), 4 * velocity) << robot.name;
  }
}

// In the air only the IMU is used: a constant rate turns the trunk by exactly rate times time, and the fall
// is a parabola.
TEST(LeggedStateEstimatorTest, IntegratesTheGyroscopeInTheAir) {
  LeggedStateEstimatorParams params{.robot = DogBot()};
  params.initial = Standing(params.robot);
  const Vec<3> rate_B(0.5, -1, 2);
  params.initial.v_W = {1, 0, 4};
  params.initial.q_WB = QuaternionFromRotationVector({0.3, 0.2, 0.1});
  Rig rig(params);
  ContactSchedule air;
  for (LegContact& leg : air.legs) leg.state = ContactState::kSwing;
  for (int k = 0; k <= 800; ++k) Feed(rig, {rate_B, Vec<3>::Zero()}, params.initial, air);
  const double t = 0.8;
  const LeggedState& estimate = rig[rig->state];
  LeggedState expected = params.initial;
  expected.q_WB = QuaternionProduct(params.initial.q_WB, QuaternionFromRotationVector(t * rate_B));
  EXPECT_LT(Turn(estimate, expected).norm(), 1e-12);
  EXPECT_THAT(estimate.w_W, IsNear(expected.R_WB() * rate_B, 1e-12));
  EXPECT_THAT(estimate.v_W, IsNear(Vec<3>(1, 0, 4 - kGravity * t), 1e-12));
  EXPECT_THAT(estimate.p_WB - params.initial.p_WB, IsNear(Vec<3>(t, 0, 4 * t - kGravity * t * t / 2), 1e-12));
  EXPECT_EQ(rig[rig->diagnostics].feet, 0);
}

TEST(LeggedStateEstimatorTest, AnImuAnywhereOnTheTrunkGivesTheSameEstimate) {
  SwayingRobot robot(DogBot(), 0.5);
  LeggedStateEstimatorParams params = Params(robot, DogBot());
  Rig at_origin(params);
  params.robot.imu_B = {0.2, -0.1, 0.05};
  Rig elsewhere(params);
  for (int k = 0; k < 3000; ++k, robot.Advance()) {
    const LeggedState x = robot.State();
    Feed(at_origin, robot.Imu(), x, AllStand());
    Feed(elsewhere, robot.Imu(params.robot.imu_B), x, AllStand());
    const LeggedState &a = at_origin[at_origin->state], &b = elsewhere[elsewhere->state];
    ASSERT_LT((b.v_W - a.v_W).norm(), 3e-3) << k;
    ASSERT_LT((b.p_WB - a.p_WB).norm(), 5e-4) << k;
    ASSERT_LT(Turn(a, b).norm(), 5e-4) << k;
  }
}

// Sensors with the noise that the filter assumes.
TEST(LeggedStateEstimatorTest, FiltersNoiseWhileStanding) {
  SwayingRobot robot(DogBot(), 0);
  LeggedStateEstimatorParams params = Params(robot, DogBot());
  const LeggedState x = robot.State();
  RandomStream random(3);
  Rig rig(params);
  double squares = 0, believed = 0;
  constexpr int kTicks = 10000;
  for (int k = 0; k < kTicks; ++k) {
    ImuMeasurement imu = robot.Imu();
    imu.specific_force_B += Normal(random, 0.05);
    imu.angular_velocity_B += Normal(random, 0.005);
    LeggedState measured = x;
    for (int j = 0; j < kNumJoints; ++j) measured.q[j] += 1e-4 * random.Normal();
    Feed(rig, imu, measured, AllStand());
    squares += rig[rig->state].v_W.squaredNorm() / kTicks;
    believed += rig[rig->diagnostics].velocity_deviation.squaredNorm() / kTicks;
  }
  EXPECT_LT(std::sqrt(squares), 3e-3);
  // The filter assumes that the feet wander, which they do not here.
  EXPECT_LT(std::sqrt(squares), 1.2 * std::sqrt(believed));
  EXPECT_LT(std::sqrt(believed), 5e-3);
  EXPECT_LT(Turn(rig[rig->state], x).norm(), 5e-3);
}

// The trunk turns, because at rest a horizontal bias of the accelerometer looks like a tilt.
TEST(LeggedStateEstimatorTest, EstimatesBiases) {
  SwayingRobot robot(DogBot(), 0.7);
  LeggedStateEstimatorParams params = Params(robot, DogBot());
  params.start.specific_force_bias = 0.3;
  params.start.angular_velocity_bias = 0.05;
  const Vec<3> force_bias(0.2, -0.15, 0.1), rate_bias(0.03, -0.02, 0.04);
  RandomStream random(4);
  Rig rig(params);
  for (int k = 0; k < 30000; ++k, robot.Advance()) {
    ImuMeasurement imu = robot.Imu();
    imu.specific_force_B += force_bias + Normal(random, 0.05);
    imu.angular_velocity_B += rate_bias + Normal(random, 0.005);
    Feed(rig, imu, robot.State(), AllStand());
  }
  const LeggedEstimatorDiagnostics& diagnostics = rig[rig->diagnostics];
  EXPECT_THAT(diagnostics.angular_velocity_bias_B, IsNear(rate_bias, 2e-3));
  EXPECT_THAT(diagnostics.specific_force_bias_B, IsNear(force_bias, 0.03));
  EXPECT_LT((rig[rig->state].v_W - robot.State().v_W).norm(), 0.02);
}

// A foot that does not stand or has just landed does not affect the estimate.
TEST(LeggedStateEstimatorTest, OnlyStandingFeetCount) {
  for (const ContactState state : {ContactState::kSwing, ContactState::kLate, ContactState::kSearching}) {
    SwayingRobot robot(DogBot(), 0.5);
    Rig still(Params(robot, DogBot())), kicking(Params(robot, DogBot()));
    RandomStream random(5);
    ContactSchedule schedule;
    for (int k = 0; k < 500; ++k, robot.Advance()) {
      // Leaves the ground after 0.1 s and lands after 0.3 s; counts again after 0.32 s.
      schedule.legs[1].state = k >= 100 && k < 300 ? state : ContactState::kStance;
      const LeggedState x = robot.State();
      LeggedState kicked = x;
      if (k >= 100 && k < 319) kicked.q.segment<3>(3) += RandomVector<3>(random, 0.5);
      Feed(still, robot.Imu(), x, schedule);
      Feed(kicking, robot.Imu(), kicked, schedule);
      ASSERT_EQ(still[still->state].p_WB, kicking[kicking->state].p_WB) << k;
      ASSERT_EQ(still[still->state].v_W, kicking[kicking->state].v_W) << k;
      ASSERT_EQ(still[still->diagnostics].feet, k >= 100 && k < 319 ? 3 : 4) << k;
    }
  }
}

// A standing foot moves by 3 cm in one tick: the filter anchors it anew instead of following it.
TEST(LeggedStateEstimatorTest, AFootThatSlipsIsAnchoredAnew) {
  SwayingRobot robot(DogBot(), 0);
  Rig rig(Params(robot, DogBot()));
  LeggedState x = robot.State();
  for (int k = 0; k < 2000; ++k) {
    if (k == 1000) x.q[4] += 0.07;
    Feed(rig, robot.Imu(), x, AllStand());
    ASSERT_LT(rig[rig->state].v_W.norm(), 1e-3) << k;
  }
  EXPECT_EQ(rig[rig->diagnostics].moved_feet, 1);
  EXPECT_THAT(rig[rig->state].p_WB, IsNear(robot.State().p_WB, 1e-3));
}

TEST(LeggedStateEstimatorTest, RefusesNonsense) {
  const auto refuses = RefusesChanged<LeggedStateEstimator>({.robot = DogBot()});
  EXPECT_TRUE(refuses([](auto& p) { p.robot.contact.stiffness = 0; }, "robot.contact.stiffness"));
  EXPECT_TRUE(refuses([](auto& p) { p.start.attitude = 0; }, "start.attitude"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.q_WB.setZero(); }, "initial.q_WB"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.v_W[0] = INFINITY; }, "starts"));
  EXPECT_TRUE(refuses([](auto& p) { p.gravity = NAN; }, "gravity"));
}

TEST(LeggedStateEstimatorTest, TheSettleTimeIsSetInARun) {
  SwayingRobot robot(DogBot());
  LeggedStateEstimatorParams changed = Params(robot, DogBot());
  changed.settle_time = 0.1;
  Rig plain(Params(robot, DogBot())), set(Params(robot, DogBot())), built(changed);
  set.Set(set->settle_time, 0.1);
  RandomStream random(4);
  for (int k = 0; k < 300; ++k, robot.Advance()) {
    ImuMeasurement imu = robot.Imu();
    imu.specific_force_B += Normal(random, 0.2);
    ContactSchedule schedule = AllStand();
    if (k > 50 && k < 100) schedule.legs[kFrontLeft].state = ContactState::kSwing;
    for (Rig* rig : {&plain, &set, &built}) Feed(*rig, imu, robot.State(), schedule);
    ASSERT_EQ(set[set->diagnostics].feet, built[built->diagnostics].feet) << k;
  }
  EXPECT_EQ(set[set->state].v_W, built[built->state].v_W);
  EXPECT_NE(plain[plain->state].v_W, built[built->state].v_W);
}

}  // namespace tenon::legged_state_estimator_test
