#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/controllers/cdpr/kino_centroidal_model.h>
#include <tenon/controllers/cdpr/reference_balancer.h>
#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <initializer_list>

namespace tenon::reference_balancer_test {

const Eigen::Vector3d kGravity(0, 0, -9.81);

/// The wrench that is missing for the acceleration of the reference, with a load.
Vector6d Imbalance(const CdprDescription& robot, const CdprReference& reference, const LoadEstimate& load) {
  const Eigen::Matrix3d R = RotationFromEuler(reference.euler);
  const Vec<3> arm = R * load.payload.p_B, g = kGravity - reference.acceleration;
  Vector6d sum = CalcCableKinematics(robot, reference.position, R).structure * reference.tension;
  sum.head<3>() += (robot.mass + load.payload.mass) * g + load.rest.force_W;
  sum.tail<3>() += load.payload.mass * arm.cross(g) + load.rest.torque_W;
  return sum;
}

CdprReference Hold(const CdprDescription& robot, const Eigen::Vector3d& position) {
  return EquilibriumPath(robot, Path::Hold(position)).At(0);
}

TEST(ReferenceBalancerTest, WithoutLoadAndAccelerationTheReferenceStays) {
  const CdprDescription robot = test::FourCableRobot();
  const CdprReference reference = Hold(robot, {0.3, 1, 2});
  TestRig<ReferenceBalancer> rig(ReferenceBalancerParams{robot});
  rig.Fix(rig->reference, reference).Tick();
  const CdprReference& balanced = rig[rig->balanced];
  EXPECT_THAT(balanced.euler, IsNear(reference.euler, 1e-9));
  EXPECT_THAT(balanced.tension, IsNear(reference.tension, 1e-6));
  EXPECT_THAT(balanced.length, IsNear(reference.length, 1e-9));
}

// One step of Newton's method per tick converges to the attitude and the tensions that carry the load.
TEST(ReferenceBalancerTest, CarriesAPayloadAndARest) {
  for (CdprDescription robot : {test::FourCableRobot(), test::EightCableRobot()}) {
    robot.cable.tension_min = 0;
    CdprReference reference = Hold(robot, {0.2, 0.4, 2});
    reference.acceleration = {0.3, -0.2, 0.1};
    const LoadEstimate load{.payload = {3, {0.05, 0.3, -0.1}}, .rest = {{2, -1, 3}, {0.1, 0, 0}}};
    TestRig<ReferenceBalancer> rig(ReferenceBalancerParams{robot});
    rig.Fix(rig->reference, reference).Fix(rig->load, load);
    for (int k = 0; k < 20; ++k) rig.Tick();
    const CdprReference& balanced = rig[rig->balanced];
    EXPECT_EQ(balanced.position, reference.position);
    EXPECT_LT(Imbalance(robot, balanced, load).norm(), 1e-6) << robot.name;
    const CableKinematics cables =
        CalcCableKinematics(robot, balanced.position, RotationFromEuler(balanced.euler));
    EXPECT_THAT(balanced.length, IsNear(cables.length, 1e-12));
  }
}

// Tensions of eight cables that would leave the bounds stay at them.
TEST(ReferenceBalancerTest, TensionsStayWithinTheBounds) {
  const CdprDescription robot = test::EightCableRobot();
  const CdprReference reference = Hold(robot, {0.2, 0.4, 2});
  const LoadEstimate load{.payload = {3, {0.05, 0.3, -0.1}}};
  ReferenceShift shift;
  BalancedReference balanced(robot);
  for (int k = 0; k < 20; ++k) balanced.Calc(reference, load, {}, shift);
  EXPECT_GE(balanced.tension().minCoeff(), robot.cable.tension_min);
  EXPECT_EQ((balanced.tension().array() == robot.cable.tension_min).any(), true);
  CdprReference held = reference;
  held.euler = balanced.euler();
  held.tension = balanced.tension();
  EXPECT_LT(Imbalance(robot, held, load).norm(), 1e-6);
}

// A load beside the plane of a planar robot: what is in the plane is balanced.
TEST(ReferenceBalancerTest, APlanarRobotRemainsInItsPlane) {
  for (const int cables : {2, 4}) {
    const CdprDescription robot = test::PlanarRobot(cables);
    const CdprReference reference = Hold(robot, {0.3, 0, 2.2});
    const LoadEstimate load{.payload = {3, {0.05, 0.2, -0.1}}, .rest = {{4, 7, 0}, {1, 0.5, 2}}};
    ReferenceShift shift;
    BalancedReference balanced(robot);
    for (int k = 0; k < 30; ++k) balanced.Calc(reference, load, {}, shift);
    CdprReference held = reference;
    held.euler = balanced.euler();
    held.tension = balanced.tension();
    EXPECT_LT(std::abs(held.euler[0]) + std::abs(held.euler[2]), 1e-12) << cables;
    const Vector6d missing = Imbalance(robot, held, load);
    for (const int motion : {0, 2, 4}) EXPECT_LT(std::abs(missing[motion]), 1e-6) << cables << ", " << motion;
  }
}

CableVector Broken(int cables, std::initializer_list<int> which) {
  CableVector broken = CableVector::Zero(cables);
  for (const int i : which) broken[i] = 1;
  return broken;
}

// Any one of twelve cables may break, with and without a payload: the others carry the load within their
// bounds.
TEST(ReferenceBalancerTest, DoesWithoutACableThatIsBroken) {
  CdprDescription robot = test::TwoRingRobot(12);
  robot.cable.tension_min = 5;
  const CdprReference reference =
      EquilibriumPath(robot, Path::Hold({0.2, 0.4, 2}),
                      StaticsOptions{.attitude = Eigen::Vector3d(0, 0, 0), .tension_aim = 20})
          .At(0);
  LoadEstimate load;
  for (const double mass : {0.0, 2.0}) {
    load.payload = {mass, {0.05, 0.1, -0.1}};
    for (int i = 0; i < 12; ++i) {
      TestRig<ReferenceBalancer> rig(ReferenceBalancerParams{robot});
      rig.Fix(rig->reference, reference).Fix(rig->load, load).Fix(rig->broken, Broken(12, {i}));
      for (int k = 0; k < 20; ++k) rig.Tick();
      CdprReference balanced = rig[rig->balanced];
      balanced.tension[i] = 0;
      EXPECT_LT(Imbalance(robot, balanced, load).norm(), 1e-6) << "cable " << i;
      for (int j = 0; j < 12; ++j)
        if (j != i) {
          EXPECT_GE(balanced.tension[j], 5);
        }
      EXPECT_LT((balanced.euler - reference.euler).norm(), 0.02);
    }
  }
}

// Three cables of four hold a platform only above the triangle of their anchors.
TEST(BalancedReferenceTest, ReportsWhenTheOthersCannotHoldThePlatform) {
  const CdprDescription robot = test::FourCableRobot();  // the first cable's anchor is in front, on the left
  const auto held = [&](const Eigen::Vector3d& position) {
    const CdprReference reference = Hold(robot, position);
    ReferenceShift shift;
    BalancedReference balanced(robot);
    for (int k = 0; k < 40; ++k) balanced.Calc(reference, {}, Broken(4, {0}), shift);
    const bool without = shift.held;
    balanced.Calc(reference, {}, {}, shift);
    EXPECT_TRUE(shift.held) << "with all cables again";
    return without;
  };
  EXPECT_TRUE(held({-0.8, -1, 2}));
  EXPECT_FALSE(held({0.8, 1, 2}));
}

// In balance the rates of the model of the MPC are zero.
TEST(BalancedReferenceTest, IsAnEquilibriumOfTheModelWithPayload) {
  const CdprDescription robot = test::FourCableRobot();
  const CdprReference reference = Hold(robot, {0.2, 0.4, 2});
  const LoadEstimate load{.payload = {4, {0.1, 0.3, -0.1}}, .rest = {{3, -2, 1}, {0.2, 0.1, -0.1}}};
  ReferenceShift shift;
  BalancedReference balanced(robot);
  for (int k = 0; k < 20; ++k) balanced.Calc(reference, load, {}, shift);

  const PlatformState platform{.p_WB = reference.position, .q_WB = QuaternionFromRotation(balanced.R_WB())};
  const CentroidalState x = CentroidalStateOf(robot, platform, load.payload);
  KinoCentroidalModel<4> model(robot);
  model.SetPayload(robot, {robot, load.payload});
  const Eigen::Vector3d com_W = balanced.R_WB() * LoadedPlatform(robot, load.payload).com_B;
  const Eigen::Vector3d force = load.rest.force_W, torque = load.rest.torque_W;
  model.load << force, torque - com_W.cross(force);
  CentroidalState rate;
  model.Derivative(x, balanced.tension(), rate);
  EXPECT_LT(rate.norm(), 1e-7) << rate.transpose();
}

TEST(ReferenceBalancerTest, ForgetsALoadThatIsGone) {
  const CdprDescription robot = test::FourCableRobot();
  const CdprReference reference = Hold(robot, {0, 0.5, 2});
  TestRig<ReferenceBalancer> rig(ReferenceBalancerParams{robot});
  rig.Fix(rig->reference, reference).Fix(rig->load, {.payload = {5, {0, 0.4, 0}}}).Tick();
  EXPECT_GT((rig[rig->balanced].tension - reference.tension).norm(), 5);
  rig.Fix(rig->load, LoadEstimate{}).Tick();
  EXPECT_THAT(rig[rig->balanced].tension, IsNear(reference.tension, 1e-6));
}

TEST(ReferenceGeneratorTest, PlaysThePathAtItsRateAndHoldsItBetween) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1.005);
  EXPECT_THAT(rig[rig->reference].position, IsNear(Eigen::Vector3d(0.2, 0, 2), 1e-12));
  EXPECT_THAT(rig[rig->reference].tension, IsNear(path->At(1).tension, 1e-12));
  rig.Tick();
  EXPECT_THAT(rig[rig->reference].position, IsNear(path->At(1.01).position, 1e-12));
}

TEST(ReferenceGeneratorTest, ShowsWhereTheRobotShouldBe) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1);
  const Geometry& geometry = rig[rig->geometry];
  ASSERT_EQ(geometry.size(), 1);
  EXPECT_EQ(geometry[0].kind, ShapeKind::kTrace);
  EXPECT_EQ(geometry[0].role, ShapeRole::kReference);
  EXPECT_THAT(geometry[0].p_W, IsNear(Vec<3>(0.2, 0, 2), 1e-12));
}

TEST(ReferenceGeneratorTest, NeedsAPath) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<ReferenceGenerator> rig; }, "path"));
}

class GoalPathTest : public testing::Test {
 protected:
  const CdprDescription robot_ = LoadCdpr(FindResource("robots", "cdpr_4"));
  const std::shared_ptr<const EquilibriumPath> circle_ =
      std::make_shared<EquilibriumPath>(robot_, Path::Circle({0, 0, 2}, 0.5, 10, 2));
  TestRig<GoalPath> rig_{GoalPathParams{.path = circle_}};
};

TEST_F(GoalPathTest, WithoutAGoalIsThePlannedOne) {
  EXPECT_EQ(rig_[rig_->path].path, circle_);
}

TEST_F(GoalPathTest, GoesOnFromTheMotionThatTheReferenceHadAndEndsAtTheEquilibriumThere) {
  const Vec<3> place(-0.3, 0.4, 2.2);
  const CdprReference before = circle_->At(4.001);
  rig_.Set(rig_->goal, rig_->GoalAt(place, 4.001, before));
  const EquilibriumPath& path = *rig_[rig_->path].path;
  CdprReference at = path.At(4.001);
  EXPECT_THAT(at.position, IsNear(before.position, 1e-12));
  EXPECT_THAT(at.velocity, IsNear(before.velocity, 1e-12));
  EXPECT_THAT(at.acceleration, IsNear(before.acceleration, 1e-12));
  EXPECT_THAT(at.euler, IsNear(before.euler, 1e-6));
  EXPECT_THAT(at.euler_rate, IsNear(before.euler_rate, 2e-3));
  EXPECT_THAT(at.tension, IsNear(before.tension, 1e-3));
  double fastest = 0;
  for (double t = 4.001; t < path.path().end_time(); t += 0.01)
    fastest = std::max(fastest, path.At(t).velocity.norm());
  EXPECT_LE(fastest, 1.3 * rig_->params.speed);
  at = path.At(100);
  EXPECT_THAT(at.position, IsNear(place, 1e-12));
  EXPECT_THAT(at.velocity, IsNear(Vec<3>::Zero(), 1e-12));
  EXPECT_THAT(at.euler, IsNear(SolveInverseGeometricoStatic(robot_, place).euler, 1e-6));
}

TEST_F(GoalPathTest, APrescribedAttitudeStays) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_8"));
  const Eigen::Vector3d attitude(0, 0, 0.1);
  const auto path = std::make_shared<EquilibriumPath>(robot, Path::Line({0, 0, 1.5}, {0.2, 0, 1.5}, 2),
                                                      StaticsOptions{.attitude = attitude});
  TestRig<GoalPath> rig(GoalPathParams{.path = path});
  rig.Set(rig->goal, rig->GoalAt({0, 0.2, 1.6}, 1, path->At(1)));
  for (const double time : {1.0, 1.4, 9.0})
    EXPECT_THAT(rig[rig->path].path->At(time).euler, IsNear(attitude, 1e-9)) << time;
}

TEST_F(GoalPathTest, APlaceThatNoPathLeadsToIsRefused) {
  EXPECT_TRUE(Throws<ParameterError>([&] { rig_->GoalAt({0, 0, 50}, 1, circle_->At(1)); }, "cdpr_4"));
}

TEST_F(GoalPathTest, RefusesNonsense) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<GoalPath> rig; }, "path"));
  EXPECT_TRUE(Refuses<GoalPath>({.path = circle_, .speed = 0}, "speed"));
  EXPECT_TRUE(Refuses<GoalPath>({.path = circle_, .shortest = -1}, "shortest"));
}

}  // namespace tenon::reference_balancer_test
