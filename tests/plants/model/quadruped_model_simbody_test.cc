// The model against Simbody's operators.

#include <tenon/tests/plants/model/quadruped_simbody.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::quadruped_model_simbody_test {

constexpr double kTolerance = 1e-10;

TEST(QuadrupedModelSimbodyTest, SameInEveryQuantity) {
  for (QuadrupedDescription robot : {test::DogBot(), test::A1(), test::SkewDogBot()}) {
    robot.drive.rotor_inertia = 0;
    test::QuadrupedSimbody simbody(robot);
    const QuadrupedModel model(robot);
    RandomStream random(22);
    QuadrupedDynamics dynamics;
    for (int i = 0; i < 20; ++i) {
      const LeggedState x = test::RandomState(random);
      model.Calc(x, &dynamics);
      simbody.Calc(x, model.gravity());
      const QuadrupedDynamics& expected = simbody.out;
      EXPECT_THAT(dynamics.M, IsNear(expected.M, kTolerance));
      EXPECT_THAT(dynamics.coriolis, IsNear(expected.coriolis, kTolerance));
      EXPECT_THAT(dynamics.gravity, IsNear(expected.gravity, kTolerance));
      EXPECT_THAT(dynamics.leg_momentum, IsNear(expected.leg_momentum, kTolerance));
      EXPECT_THAT(dynamics.com_W, IsNear(expected.com_W, kTolerance));
      EXPECT_THAT(dynamics.com_velocity_W, IsNear(expected.com_velocity_W, kTolerance));
      EXPECT_THAT(dynamics.angular_momentum_W, IsNear(expected.angular_momentum_W, kTolerance));
      EXPECT_THAT(dynamics.centroidal_inertia_W, IsNear(expected.centroidal_inertia_W, kTolerance));
      for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
        EXPECT_THAT(dynamics.feet[leg].p_W, IsNear(expected.feet[leg].p_W, kTolerance));
        EXPECT_THAT(dynamics.feet[leg].v_W, IsNear(expected.feet[leg].v_W, kTolerance));
        EXPECT_THAT(dynamics.feet[leg].bias, IsNear(expected.feet[leg].bias, kTolerance));
        EXPECT_THAT(dynamics.FootJacobian(static_cast<int>(leg)),
                    IsNear(simbody.foot_jacobian[leg], kTolerance));
      }
    }
  }
}

}  // namespace tenon::quadruped_model_simbody_test
