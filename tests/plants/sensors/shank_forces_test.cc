#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/sensors/shank_forces.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::shank_forces_test {
namespace {

/// A force along the shank, from the knee to the foot, has in the shank's axes the direction that the
/// description says.
TEST(ShankForcesTest, AForceAlongTheShankIsAlongItInItsAxes) {
  RandomStream random(3);
  const QuadrupedDescription robot = test::DogBot();
  const LeggedState x = test::RandomState(random);
  const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(robot), x);
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg)
    forces[leg] = dynamics.feet[leg].p_W - dynamics.origin_W[kJointsPerLeg * leg + 2];
  TestRig<ShankForces> rig(ShankForcesParams{robot});
  rig.Fix(rig->state, x).Fix(rig->forces, forces);
  for (int leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(rig[rig->shank][leg], IsNear(robot.legs[leg].foot_J, 1e-12)) << leg;
}

}  // namespace
}  // namespace tenon::shank_forces_test
