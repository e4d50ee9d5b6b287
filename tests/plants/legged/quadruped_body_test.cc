// The plant's equations of motion against Simbody's own.

#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/tests/plants/model/quadruped_simbody.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::quadruped_body_test {

using test::Stacked, test::Velocities;

TEST(QuadrupedBodyTest, AgreesWithSimbodysArticulatedBodies) {
  for (QuadrupedDescription robot : {test::DogBot(), test::A1(), test::SkewDogBot()}) {
    robot.drive.rotor_inertia = 0;
    test::QuadrupedSimbody simbody(robot);
    QuadrupedBody body(robot);
    RandomStream random(51);
    for (int i = 0; i < 20; ++i) {
      const LeggedState x = test::RandomState(random);
      const Vec<12> torque = test::RandomVector<12>(random, 60);
      body.SetState(x);
      const Vec<18> expected = Stacked(simbody.CalcAcceleration(x, torque));
      EXPECT_THAT(Stacked(body.Acceleration(torque, {}, 0)), IsNear(expected, 1e-11 * expected.norm()));
    }
  }
}

TEST(QuadrupedBodyTest, FeetCentreOfMassAndEnergyAgreeWithSimbodys) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1(), test::SkewDogBot()}) {
    test::QuadrupedSimbody simbody(robot);
    const QuadrupedModel model(robot);
    QuadrupedDynamics dynamics;
    QuadrupedBody body(robot);
    RandomStream random(52);
    for (int i = 0; i < 20; ++i) {
      const LeggedState x = test::RandomState(random);
      body.SetState(x);
      simbody.Calc(x, 0);
      model.Calc(x, &dynamics);
      for (int leg = 0; leg < kNumLegs; ++leg) {
        const QuadrupedDynamics::Foot& expected = simbody.out.foot(leg);
        const FootMotion foot = body.Foot(leg);
        EXPECT_THAT(foot.p_W, IsNear(expected.p_W, 1e-12));
        EXPECT_THAT(foot.v_W, IsNear(expected.v_W, 1e-12));
        EXPECT_THAT(foot.w_W, IsNear(dynamics.foot(leg).w_W, 1e-12));
      }
      EXPECT_THAT(body.Com(), IsNear(simbody.out.com_W, 1e-12));
      const Vec<18> u = Velocities(x);
      const double energy = u.dot(simbody.out.M * u) / 2 + robot.drive.rotor_inertia / 2 * x.qd.squaredNorm();
      EXPECT_NEAR(body.KineticEnergy(), energy, 1e-11 * energy);
    }
  }
}

TEST(QuadrupedBodyTest, CopiesHaveTheSameStateAndAreIndependent) {
  const QuadrupedDescription robot = test::DogBot();
  RandomStream random(55);
  const LeggedState x = test::RandomState(random), y = test::RandomState(random);
  QuadrupedBody body(robot), expected(robot);
  body.SetState(x);
  expected.SetState(x);
  const QuadrupedBody copy(body);
  body.SetState(y);
  const Vec<12> torque = test::RandomVector<12>(random, 60);
  const Vec<3> p_B = test::RandomVector<3>(random, 0.3);
  EXPECT_EQ(Stacked(copy.Acceleration(torque, {}, 0)), Stacked(expected.Acceleration(torque, {}, 0)));
  EXPECT_EQ(copy.KineticEnergy(), expected.KineticEnergy());
  EXPECT_EQ(copy.Com(), expected.Com());
  for (int i = 0; i <= kNumJoints; ++i) EXPECT_EQ(copy.Position(i, p_B), expected.Position(i, p_B));
  for (int leg = 0; leg < kNumLegs; ++leg) {
    EXPECT_EQ(copy.Foot(leg).p_W, expected.Foot(leg).p_W);
    EXPECT_NE(copy.Foot(leg).p_W, body.Foot(leg).p_W);
  }
  QuadrupedBody other(copy);  // evaluated after `copy` has
  other.SetState(y);
  EXPECT_EQ(Stacked(other.Acceleration(torque, {}, 0)), Stacked(body.Acceleration(torque, {}, 0)));
  EXPECT_EQ(other.Position(7, p_B), body.Position(7, p_B));
}

/// (M + D) u' = M u0', where u0' are the accelerations without rotors.
TEST(QuadrupedBodyTest, RotorsAddToTheMassMatrix) {
  QuadrupedDescription robot = test::A1();
  robot.drive.rotor_inertia = 0.02;
  test::QuadrupedSimbody simbody(robot);  // without rotors
  QuadrupedBody body(robot);
  RandomStream random(53);
  for (int i = 0; i < 20; ++i) {
    const LeggedState x = test::RandomState(random);
    const Vec<12> torque = test::RandomVector<12>(random, 30);
    body.SetState(x);
    const Vec<18> with = Stacked(body.Acceleration(torque, {}, 0));
    const Vec<18> without = Stacked(simbody.CalcAcceleration(x, torque));
    simbody.Calc(x, 0);
    Vec<18> expected = simbody.out.M * without, actual = simbody.out.M * with;
    actual.tail<12>() += 0.02 * with.tail<12>();
    EXPECT_THAT(actual, IsNear(expected, 1e-11 * (1 + expected.norm())));
    EXPECT_GT((with - without).norm(), 1);
  }
}

/// A force on any body accelerates the CoM by Newton's law and does the work of its point.
TEST(QuadrupedBodyTest, ForcesActAtTheirPoints) {
  const QuadrupedDescription robot = test::A1();
  test::QuadrupedSimbody simbody(robot);
  QuadrupedBody body(robot);
  RandomStream random(54);
  const double h = 1e-6;
  for (int on = 0; on <= kNumJoints; ++on) {
    LeggedState x = test::RandomState(random);
    const Vec<3> p_B = test::RandomVector<3>(random, 0.3), force = test::RandomVector<3>(random, 50);
    const Vec<3> torque = test::RandomVector<3>(random, 10);
    body.SetState(x);
    const PointForce at{on, body.Position(on, p_B), force, torque};
    const Vec<18> change = Stacked(body.Acceleration(Vec<12>::Zero(), {&at, 1}, 9.81)) -
                           Stacked(body.Acceleration(Vec<12>::Zero(), {}, 9.81));
    // The power, from finite differences of four points of the body.
    const auto moved = [&](double dt) {
      LeggedState y = x;
      y.p_WB += dt * x.v_W;
      y.q_WB = QuaternionProduct(QuaternionFromRotationVector(dt * x.w_W), x.q_WB);
      y.q += dt * x.qd;
      body.SetState(y);
      Eigen::Matrix<double, 3, 4> points;
      points.col(0) = body.Position(on, p_B);
      for (int i = 0; i < 3; ++i) points.col(1 + i) = body.Position(on, p_B + Vec<3>::Unit(i));
      return points;
    };
    const Eigen::Matrix<double, 3, 4> now = moved(0), rate = (moved(h) - moved(-h)) / (2 * h);
    Vec<3> w = Vec<3>::Zero();  // from the motion of the body's axes e: w = sum e x e' / 2
    for (int i = 1; i < 4; ++i)
      w += Vec<3>(now.col(i) - now.col(0)).cross(Vec<3>(rate.col(i) - rate.col(0))) / 2;
    const double power = force.dot(rate.col(0)) + torque.dot(w);
    simbody.Calc(x, 0);
    Vec<18> momentum_rate = simbody.out.M * change;
    momentum_rate.tail<12>() += robot.drive.rotor_inertia * change.tail<12>();
    EXPECT_NEAR(Velocities(x).dot(momentum_rate), power, 1e-6 * (1 + std::abs(power))) << on;
    EXPECT_THAT(momentum_rate.head<3>(), IsNear(force, 1e-10)) << on;
  }
}

}  // namespace tenon::quadruped_body_test
