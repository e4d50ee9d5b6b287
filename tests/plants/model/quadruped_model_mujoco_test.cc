// Mass matrix, bias and forward dynamics without contact against MuJoCo.

#include <tenon/tests/plants/model/quadruped_mujoco.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::quadruped_model_mujoco_test {

class MuJoCo {
 public:
  explicit MuJoCo(const QuadrupedDescription& robot)
      : model_(test::LoadMuJoCo(test::Mjcf(robot))), data_(mj_makeData(model_.get())) {}
  /// Mass matrix, bias and accelerations under torques, in our coordinates.
  void Calc(const LeggedState& x, const Vec<12>& tau) {
    const Eigen::Matrix3d R = x.R_WB();
    T_.setIdentity();
    T_.block<3, 3>(3, 3) = R.transpose();  // MuJoCo has w in B; its rate is R^T w', because w x w = 0
    const Vec<4> q_WB = x.q_WB.normalized();
    const Vec<3> w_B = R.transpose() * x.w_W;
    Eigen::Map<Eigen::VectorXd>(data_->qpos, 19) << x.p_WB, q_WB, x.q;
    Eigen::Map<Eigen::VectorXd>(data_->qvel, 18) << x.v_W, w_B, x.qd;
    Eigen::Map<Eigen::VectorXd>(data_->qfrc_applied, 18) << Vec<6>::Zero(), tau;
    mj_forward(model_.get(), data_.get());
  }
  Eigen::MatrixXd M() const {
    Eigen::Matrix<double, 18, 18, Eigen::RowMajor> M;
    mj_fullM(model_.get(), M.data(), data_->qM);
    return T_.transpose() * M * T_;
  }
  Eigen::VectorXd Bias() const { return T_.transpose() * Eigen::Map<Eigen::VectorXd>(data_->qfrc_bias, 18); }
  Eigen::VectorXd Acceleration() const {
    return T_.transpose() * Eigen::Map<Eigen::VectorXd>(data_->qacc, 18);
  }

 private:
  test::MuJoCoModel model_;
  test::MuJoCoData data_;
  Eigen::Matrix<double, 18, 18> T_;
};

TEST(QuadrupedModelMuJoCoTest, SameDynamics) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1()}) {
    MuJoCo mujoco(robot);
    const QuadrupedModel model(robot);
    RandomStream random(21);
    QuadrupedDynamics dynamics;
    for (int i = 0; i < 20; ++i) {
      const LeggedState x = test::RandomState(random);
      const Vec<12> tau = test::RandomVector<12>(random, 30);
      mujoco.Calc(x, tau);
      model.Calc(x, &dynamics);
      Vec<18> force = -dynamics.bias();
      force.tail<12>() += tau;
      const Vec<18> a = test::Solve(dynamics.M, force);
      EXPECT_THAT(dynamics.M, IsNear(mujoco.M(), 1e-8));
      EXPECT_THAT(dynamics.bias(), IsNear(mujoco.Bias(), 1e-8));
      EXPECT_THAT(a, IsNear(mujoco.Acceleration(), 1e-8 * (1 + a.norm())));
    }
  }
}

}  // namespace tenon::quadruped_model_mujoco_test
