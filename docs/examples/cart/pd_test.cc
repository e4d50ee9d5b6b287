// Tests a block without simulator and diagram.

#include <tenon/tests/testing/test_rig.h>

#include "cart.h"
#include <gtest/gtest.h>

TEST(PdTest, PushesTowardsTheReference) {
  tenon::TestRig<Pd> rig(PdParams{.kp = 3});
  rig.Fix(rig.system().x, {1, 0}).Fix(rig.system().ref, 2).Tick();
  EXPECT_EQ(rig[rig.system().u], 3);
}
