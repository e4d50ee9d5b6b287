#include "momentum_observer.h"

#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

TEST(MomentumObserverTest, TakesMomentumFromNowhereForAForce) {
  const tenon::QuadrupedDescription robot = tenon::LoadQuadruped(tenon::FindResource("robots", "dogbot"));
  tenon::LeggedState moving;
  moving.v_W[0] = 0.1;

  tenon::TestRig<MomentumObserver> rig(MomentumObserverParams{.robot = robot, .bandwidth = 25});
  rig.Fix(rig.system().state, moving).Fix(rig.system().foot_forces, tenon::FootForces()).Tick();
  EXPECT_NEAR(rig[rig.system().wrench].force_W[0], 25 * robot.mass() * 0.1, 1e-9);
}
