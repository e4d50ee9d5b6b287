// The walk of tenon-quadruped with MuJoCo in the place of the plant.

#include <tenon/tests/apps/run_case.h>

namespace tenon::quadruped_mujoco_test {

class QuadrupedMujocoCasesTest : public test::CaseTest {
 protected:
  test::Case Walk(const char* engine) const {
    return Run(QUADRUPED_MUJOCO, std::string("A1 --duration 3 --set custom.engine=") + engine);
  }
};

TEST_F(QuadrupedMujocoCasesTest, BothEnginesGiveTheSameWalk) {
  const test::Case tenon = Walk("tenon"), mujoco = Walk("mujoco");
  EXPECT_TRUE(mujoco.finished());
  EXPECT_EQ(mujoco["evaluations"], 0);  // Tenon's integrator had nothing to do
  EXPECT_NEAR(mujoco["distance_m"], tenon["distance_m"], 1e-3);
  EXPECT_NEAR(mujoco["com_error_max_m"], tenon["com_error_max_m"], 5e-4);
  EXPECT_NEAR(mujoco.largest_foot_error(), tenon.largest_foot_error(), 2e-3);
  EXPECT_NEAR(mujoco["torque_max_N_m"], tenon["torque_max_N_m"], 3);
}

}  // namespace tenon::quadruped_mujoco_test
