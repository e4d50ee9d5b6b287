#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/controllers/legged/whole_body/rope_tensions.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/SVD>

namespace tenon::rope_tensions_test {

using test::A1, test::DogBot, test::RandomState, test::RandomVector;

constexpr double kSlope = 0.6,
                 kSide = 0.3;  // inclination of the ground, angle of the ropes to the CoM's path [rad]

/// A robot on a slope with two ropes through points beside its CoM, which include the angle 2 kSide.
struct OnSlope {
  RopeTensionsParams params;
  LeggedState state;
  GroundPlane ground{.slope = {std::tan(kSlope), 0}};
  double weight;

  /// `ahead` is 1 for ropes to anchors up the slope, -1 for anchors down the slope.
  explicit OnSlope(double tension_max = 1000, double ahead = 1) : params{.robot = test::DogBot()} {
    state.q = params.robot.stance;
    state.q_WB = QuaternionFromRotationVector({0, -kSlope, 0});
    const QuadrupedModel model(params.robot);
    const Vec<3> com = test::DynamicsOf(model, state).com_W, com_B = state.R_WB().transpose() * com;
    weight = model.mass() * model.gravity();
    for (const double side : {1.0, -1.0}) {
      const Vec<3> attachment = com_B + Vec<3>(0, 0.1 * side, 0);
      const Vec<3> along = state.R_WB() * Vec<3>(std::cos(kSide) * ahead, std::sin(kSide) * side, 0);
      params.ropes.push_back(
          {side > 0 ? "left" : "right", state.R_WB() * attachment + 5 * along, attachment, 0, tension_max});
    }
  }
};

// Statics: 2 T cos(kSide) = m g sin(slope), and the feet carry m g cos(slope) along the normal.
TEST(RopeTensionsTest, CarryTheWeightAlongTheSlope) {
  const OnSlope on;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero())).Tick();
  const double tension = on.weight * std::sin(kSlope) / (2 * std::cos(kSide));
  const CableVector command = rig[rig->command];
  EXPECT_THAT(command, IsNear(Vec<2>(tension, tension), 1e-2));
  EXPECT_TRUE(rig[rig->wrench].force_W.isZero(0));

  rig.Fix(rig->tension, command).Tick();
  const Vec<3> feet = Vec<3>(0, 0, on.weight) - rig[rig->wrench].force_W;
  EXPECT_THAT(feet, IsNear(Vec<3>(on.weight * std::cos(kSlope) * on.ground.Normal()), 1e-2));
  EXPECT_TRUE(rig[rig->wrench].torque_W.isZero(1e-3));

  // The feet's part along the slope loads them unequally, which costs, so that they have slightly less of it.
  rig.Set(rig->share, 0.5);
  EXPECT_THAT(rig.Tick()[rig->command], IsNear(Vec<2>(tension, tension) / 2, 0.02 * tension));
}

TEST(RopeTensionsTest, DoNotPullOnLevelGround) {
  OnSlope on;
  on.state.q_WB = {1, 0, 0, 0};
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->state, on.state).Fix(rig->ground, GroundPlane());
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero())).Tick();
  EXPECT_THAT(rig[rig->command], IsNear(Vec<2>(0, 0), 1e-2));
}

/// Force of the feet along the ground over that along its normal, if they and the ropes balance the weight
/// and a force of the observer.
double FrictionNeeded(TestRig<RopeTensions>& rig, const OnSlope& on, const CableVector& tension,
                      double pull) {
  rig.Fix(rig->tension, tension).Tick();
  const Vec<3> up_slope = on.state.R_WB().col(0), normal = on.ground.Normal();
  const Vec<3> feet = Vec<3>(0, 0, on.weight) + pull * up_slope - rig[rig->wrench].force_W;
  return (feet - feet.dot(normal) * normal).norm() / feet.dot(normal);
}

// A pull down the slope. Feet and nominal tensions would need more friction than there is.
TEST(RopeTensionsTest, CarryWhatExceedsTheFrictionOfTheFeet) {
  OnSlope on;
  on.params.friction = 0.2;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero()));
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground).Tick();
  const CableVector nominal = rig[rig->command];
  constexpr double kPull = 80;  // [N]
  EXPECT_GT(FrictionNeeded(rig, on, nominal, kPull), 0.4);
  rig.Fix(rig->external, WrenchEstimate{.force_W = -kPull * on.state.R_WB().col(0)}).Tick();
  const CableVector command = rig[rig->command];
  EXPECT_LT(FrictionNeeded(rig, on, command, kPull), 0.2 / std::sqrt(2) + 1e-3);
  // Ropes at their limits leave the rest to the feet.
  on.params.ropes[0].tension_max = on.params.ropes[1].tension_max = nominal[0] + 10;
  TestRig<RopeTensions> weak(on.params);
  weak.Fix(weak->tension, CableVector(Vec<2>::Zero()))
      .Fix(weak->state, on.state)
      .Fix(weak->ground, on.ground);
  weak.Fix(weak->external, WrenchEstimate{.force_W = -kPull * on.state.R_WB().col(0)}).Tick();
  EXPECT_THAT(weak[weak->command], IsNear(CableVector(nominal.array() + 10), 1e-9));
}

// With its feet in the air the robot hangs by its ropes, which then carry as much of the weight as they can.
TEST(RopeTensionsTest, CarryTheRobotIfNoFootStands) {
  OnSlope on;
  for (Rope& rope : on.params.ropes) rope.anchor_W = on.state.R_WB() * rope.attachment_B + Vec<3>(0, 0, 5);
  ContactSchedule schedule;
  for (LegContact& leg : schedule.legs) leg.state = ContactState::kSearching;
  const CableVector command = RopeTensions(on.params).CommandAt(on.state, on.ground, schedule);
  EXPECT_THAT(command, IsNear(Vec<2>(on.weight, on.weight) / 2, 0.1));
}

TEST(RopeTensionsTest, DoWithoutALostRope) {
  const OnSlope on;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero()));
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground).Tick();
  const CableVector nominal = rig[rig->command];
  rig.Fix(rig->tension, CableVector(Vec<2>(0.2 * nominal[0], 0.9 * nominal[1])));
  for (int n = 0; n < 40; ++n) rig.Tick();
  EXPECT_THAT(rig[rig->command], IsNear(nominal, 1e-3));  // not yet
  EXPECT_THAT(rig[rig->lost], IsNear(Vec<2>(0, 0), 0));
  for (int n = 0; n < 20; ++n) rig.Tick();
  const CableVector alone = rig[rig->command];
  EXPECT_NEAR(alone[0], 0, 1e-9);
  EXPECT_GT(alone[1], 1.2 * nominal[1]);
  EXPECT_THAT(rig[rig->lost], IsNear(Vec<2>(1, 0), 0));
  rig.Fix(rig->tension, nominal).Tick();
  EXPECT_NEAR(rig[rig->command][0], 0, 1e-9);  // it stays lost
}

TEST(RopeTensionsTest, StayWithinTheirLimits) {
  for (const double ahead : {1.0, -1.0}) {  // ropes to the rear would have to push
    OnSlope on(50, ahead);
    on.params.ropes[0].tension_min = 5;
    TestRig<RopeTensions> rig(on.params);
    rig.Fix(rig->tension, CableVector(Vec<2>::Zero()));
    rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground).Tick();
    EXPECT_THAT(rig[rig->command], IsNear(ahead > 0 ? Vec<2>(50, 50) : Vec<2>(5, 0), 1e-9));
  }
}

TEST(RopeTensionsTest, RefuseNoFriction) {
  OnSlope on;
  on.params.friction = 0;
  EXPECT_TRUE(Refuses<RopeTensions>(on.params, "friction"));
}

JointPdParams Params(const QuadrupedDescription& robot) {
  return {.robot = robot, .stiffness = 40, .damping = 2};
}

// Virtual work: when the joints move by dq with the feet on the ground, the torques do the work that lifts
// the robot. With all knees and hips moving alike the trunk moves up without turning.
TEST(StandingTorqueTest, DoesTheWorkThatLiftsTheRobot) {
  for (QuadrupedDescription robot : {DogBot(), A1()}) {
    const auto potential = [&](double s) {  // of the robot on its feet, the stance changed by s
      LeggedState x{.q = robot.stance};
      for (int leg = 0; leg < kNumLegs; ++leg) x.q.segment<2>(3 * leg + 1) += s * Vec<2>(1, -2);
      double depth = 0;
      for (int leg = 0; leg < kNumLegs; ++leg) depth -= robot.FootPosition(leg, x.q)[2] / kNumLegs;
      const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(robot), x);
      return robot.mass() * 9.81 * (dynamics.com_W[2] + depth);
    };
    // Legs alike in front and rear, so that the trunk stays level.
    const Vec<12> torque = StandingTorque(robot, 9.81);
    double work = 0;
    for (int leg = 0; leg < kNumLegs; ++leg) work += torque.segment<2>(3 * leg + 1).dot(Vec<2>(1, -2));
    const double h = 1e-5;
    // The feet also move horizontally, which takes no work because the forces are vertical.
    EXPECT_NEAR(work, (potential(h) - potential(-h)) / (2 * h), 1e-6 * std::abs(work)) << robot.name;
    EXPECT_GT(std::abs(work), 1);
  }
}

TEST(StandingTorqueTest, RefusesFeetInALine) {
  QuadrupedDescription robot = DogBot();
  for (LegDescription& leg : robot.legs) {
    for (JointDescription& joint : leg.joints) joint.p_PJ[1] = 0;
    leg.foot_J[1] = 0;
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { StandingTorque(robot, 9.81); }, "dogbot"));
}

TEST(JointPdTest, IsTheEquationWithinTheLimits) {
  JointPdParams params = Params(DogBot());
  TestRig<JointPd> rig(params);
  JointMotion joints{params.robot.stance, Vec<12>::Zero()};
  joints.q[2] -= 0.1;
  joints.qd[4] = 0.5;
  joints.q[8] += 100;
  rig.Fix(rig->joints, joints).Tick();
  Vec<12> expected = StandingTorque(params.robot, 9.81);
  expected[2] += 40 * 0.1;
  expected[4] -= 2 * 0.5;
  expected[8] = -60;
  EXPECT_THAT(rig[rig->torque], IsNear(expected, 1e-12));
}

TEST(JointPdTest, FollowsItsReferenceWithoutGravityCompensation) {
  JointPdParams params = Params(A1());
  params.gravity_compensation = false;
  TestRig<JointPd> rig(params);
  rig.Fix(rig->joints, JointMotion{}).Fix(rig->reference, Vec<12>::Constant(0.2)).Tick();
  EXPECT_THAT(rig[rig->torque], IsNear(Vec<12>::Constant(8), 1e-12));
}

TEST(JointPdTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<JointPd>({}, "robot"));
  EXPECT_TRUE(Refuses<JointPd>({.robot = DogBot(), .stiffness = 40, .gravity = INFINITY}, "gravity"));
}

/// s_0^2 - s^2 of a leg, 0 if it is regular.
double Penalty(const Eigen::Matrix3d& J, double min_singular_value) {
  const double s = Eigen::JacobiSVD<Eigen::Matrix3d>(J).singularValues()[2];
  return std::max(0.0, min_singular_value * min_singular_value - s * s);
}

/// Half the gradient of |J^T f - torque|^2 + penalty |f|^2.
Eigen::VectorXd Gradient(const Eigen::MatrixXd& J, const Eigen::VectorXd& torque, double penalty,
                         const Eigen::VectorXd& f) {
  return J * (J.transpose() * f - torque) + penalty * f;
}

TEST(FootForcesTest, AreTheLeastOfTheirPenalisedSquares) {
  constexpr double kMinSingularValue = 0.05;
  const QuadrupedModel model(DogBot());
  RandomStream random(31);
  int regular = 0;
  for (int i = 0; i < 50; ++i) {
    const LeggedState x = RandomState(random);
    const Vec<12> torque = RandomVector<12>(random, 20);
    QuadrupedDynamics dynamics;
    DecoupledDynamics decoupled;
    model.Calc(x, &dynamics);
    model.CalcDecoupled(x, dynamics, &decoupled);

    const FootForces alone = SolveFootForces(dynamics, torque, kMinSingularValue);
    const FootForces together = SolveFootForces(dynamics, decoupled, torque, kMinSingularValue);
    double largest = 0;
    Vec<12> stacked;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Eigen::Matrix3d& J = dynamics.feet[leg].J_leg;
      const double penalty = Penalty(J, kMinSingularValue);
      const Vec<3> tau = torque.segment<3>(3 * leg);
      EXPECT_LT(Gradient(J, tau, penalty, alone[leg]).norm(), 1e-9) << i;
      if (penalty == 0) {
        EXPECT_THAT(Vec<3>(J.transpose() * alone[leg]), IsNear(tau, 1e-9)) << i;
      }
      regular += penalty == 0;
      largest = std::max(largest, penalty);
      stacked.segment<3>(3 * leg) = together[leg];
    }
    EXPECT_LT(Gradient(decoupled.J_q, torque, largest, stacked).norm(), 1e-9) << i;
  }
  EXPECT_GT(regular, 50);
  EXPECT_LT(regular, 150);
}

}  // namespace tenon::rope_tensions_test
