// A trajectory of a quadruped with an arm in free fall, against MuJoCo.

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/attached_body_mujoco.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::quadruped_multibody_mujoco_test {

TEST(QuadrupedMultibodyMuJoCoTest, AnArmInFreeFallHasTheSameTrajectory) {
  const AttachedBody upper = test::SpringLink("upper", {0.1, 0.02, 0.08}, {0, 1, 0.3}, 0.3);
  AttachedBody fore = test::SpringLink("fore", {0, 0, 0.3}, {1, 0.2, 0}, 0.3);
  fore.on = "upper";
  QuadrupedPlantParams params{.robot = test::DogBot(), .initial = test::Standing(test::DogBot())};
  params.robot.drive.damping = params.robot.drive.friction = 0;
  params.robot.drive.rotor_inertia = 0.03;
  for (LegDescription& leg : params.robot.legs)
    for (JointDescription& joint : leg.joints) joint.lower = -INFINITY, joint.upper = INFINITY;
  params.limit_speed = false;
  params.extend = Attach({upper, fore});
  RandomStream random(59);
  params.initial.p_WB[2] = 100;
  params.initial.q_WB = {1, 0, 0, 0};
  params.initial.v_W = test::RandomVector<3>(random, 1);
  params.initial.w_W = test::RandomVector<3>(random, 2);
  params.initial.qd = test::RandomVector<12>(random, 3);
  TestRig<QuadrupedPlant> rig(params);
  rig.Fix(rig->torque, Vec<12>::Zero()).Set(rig->added_u, Eigen::Vector2d(2, -3));

  std::string mjcf = test::Mjcf(params.robot, "", test::Mjcf(upper) + test::Mjcf(fore) + "</body></body>");
  const std::string option = "<option ";
  mjcf.insert(mjcf.find(option) + option.size(), "integrator=\"RK4\" timestep=\"5e-4\" ");
  const test::MuJoCoModel model = test::LoadMuJoCo(mjcf);
  const test::MuJoCoData data(mj_makeData(model.get()));
  Eigen::Map<Eigen::VectorXd> q(data->qpos, 21), u(data->qvel, 20);
  q << params.initial.p_WB, params.initial.q_WB, params.initial.q, 0, 0;
  u << params.initial.v_W, params.initial.w_W, params.initial.qd, 2, -3;  // w in B, which is W at the start
  for (int i = 1; i <= 1000; ++i) {
    mj_step(model.get(), data.get());
    if (i % 250 != 0) continue;
    rig.RunTo(i * 5e-4);
    const LeggedState x = rig[rig->state];
    EXPECT_THAT(x.p_WB, IsNear(q.head<3>().eval(), 1e-6));
    EXPECT_THAT(x.R_WB(), IsNear(RotationFromQuaternion(q.segment<4>(3)), 1e-6));
    EXPECT_THAT(x.q, IsNear(q.segment<12>(7).eval(), 1e-6));
    EXPECT_THAT(rig[rig->added_positions], IsNear(q.tail<2>().eval(), 1e-6));
    EXPECT_THAT(rig[rig->added_speeds], IsNear(u.tail<2>().eval(), 1e-5));
  }
  EXPECT_GT(u.tail<2>().norm(), 0.1);
}

}  // namespace tenon::quadruped_multibody_mujoco_test
