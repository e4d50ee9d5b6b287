// A trajectory of a platform with an arm in free fall, against MuJoCo.

#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/plants/model/attached_body_mujoco.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cdpr_multibody_mujoco_test {

TEST(CdprMultibodyMuJoCoTest, AnArmInFreeFallHasTheSameTrajectory) {
  const AttachedBody upper = test::SpringLink("upper", {0.1, 0, -0.1}, {0, 1, 0}, -0.4);
  AttachedBody fore = test::SpringLink("fore", {0, 0, -0.4}, {1, 0.2, 0}, -0.4);
  fore.on = "upper";
  CdprPlantParams params = test::Hanging();
  params.extend = AttachToPlatform({upper, fore});
  params.w_W = {1, -2, 0.5};
  params.v_W = {0.3, 0.2, 3};
  TestRig<CdprPlant> rig(params);
  const CableVector all = CableVector::Ones(4);
  rig.Fix(rig->faults, {0 * all, all}).Fix(rig->command, 0 * all).Set(rig->added_u, Eigen::Vector2d(2, -3));

  const RigidInertia platform{params.robot.mass, Vec<3>::Zero(), params.robot.inertia_B};
  const test::MuJoCoModel model = test::LoadMuJoCo(
      "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 0 -9.81\" integrator=\"RK4\" "
      "timestep=\"1e-3\"/>"
      "<worldbody><body><freejoint/>" +
      test::Inertial(platform) + test::Mjcf(upper) + test::Mjcf(fore) +
      "</body></body></body></worldbody></mujoco>");
  const test::MuJoCoData data(mj_makeData(model.get()));
  Eigen::Map<Eigen::VectorXd> q(data->qpos, 9), u(data->qvel, 8);
  q << params.p_WB, 1, 0, 0, 0, 0, 0;
  u << params.v_W, params.w_W, 2, -3;  // MuJoCo has w in B, whose axes are those of W at the start
  for (int i = 1; i <= 800; ++i) {
    mj_step(model.get(), data.get());
    if (i % 200 != 0) continue;
    rig.RunTo(i * 1e-3);
    const PlatformState& x = rig[rig->platform];
    EXPECT_THAT(x.p_WB, IsNear(q.head<3>().eval(), 1e-7));
    EXPECT_THAT(x.R_WB(), IsNear(RotationFromQuaternion(q.segment<4>(3)), 1e-6));
    EXPECT_THAT(rig[rig->added_positions], IsNear(q.tail<2>().eval(), 1e-7));
    EXPECT_THAT(rig[rig->added_speeds], IsNear(u.tail<2>().eval(), 1e-6));
  }
  EXPECT_GT(u.tail<2>().norm(), 0.1);
}

}  // namespace tenon::cdpr_multibody_mujoco_test
