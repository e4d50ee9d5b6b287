// The model against MuJoCo, which shares nothing with it: mass matrix, bias and forward dynamics without
// contact.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cstring>
#include <memory>
#include <string>

#include "tenon/plants/description/quadruped_model.h"
#include "tenon/tests/plants/quadruped_test_robot.h"
#include "tenon/tests/testing/matchers.h"

namespace tenon {
namespace {

std::string Numbers(const Eigen::Vector3d& v) {
  return fmt::format("{} {} {}", v[0], v[1], v[2]);
}

/// By principal axes, since MuJoCo's own way to them from a full inertia is good to 1e-8 only.
std::string Inertial(const RigidInertia& body) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(body.inertia);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Vec<4> q = QuaternionFromRotation(axes);
  return fmt::format(R"(<inertial pos="{}" quat="{} {} {} {}" mass="{}" diaginertia="{}"/>)",
                     Numbers(body.com), q[0], q[1], q[2], q[3], body.mass, Numbers(principal.eigenvalues()));
}

/// The robot in MuJoCo's language; its joints are in our order.
std::string Mjcf(const QuadrupedDescription& robot) {
  std::string text =
      "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 0 -9.81\"/><worldbody><body><freejoint/>" +
      Inertial(robot.trunk);
  for (const LegDescription& leg : robot.legs) {
    for (std::size_t i = 0; i < kJointsPerLeg; ++i)
      text += fmt::format("<body pos=\"{}\"><joint type=\"hinge\" axis=\"{}\" armature=\"{}\"/>{}",
                          Numbers(leg.joints[i].p_PJ), Numbers(leg.joints[i].axis), robot.drive.rotor_inertia,
                          Inertial(leg.bodies[i]));
    text += "</body></body></body>";
  }
  return text + "</body></worldbody></mujoco>";
}

class MuJoCo {
 public:
  explicit MuJoCo(const QuadrupedDescription& robot) {
    const std::string text = Mjcf(robot);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "robot.xml", static_cast<int>(text.size()));
    std::memcpy(files.filedata[0], text.data(), text.size());
    char error[1000] = "";
    model_.reset(mj_loadXML("robot.xml", &files, error, sizeof(error)));
    mj_deleteVFS(&files);
    if (model_ == nullptr) throw std::runtime_error(error);
    data_.reset(mj_makeData(model_.get()));
  }
  /// Mass matrix, bias and accelerations under torques, in our coordinates.
  void Calc(const LeggedState& x, const Vec<12>& tau) {
    const Eigen::Matrix3d R = x.R_WB();
    T_.setIdentity();
    T_.block<3, 3>(3, 3) = R.transpose();  // its trunk turns with w in B; its rate is R^T w', as w x w = 0
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
  struct Free {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  Eigen::Matrix<double, 18, 18> T_;
};

TEST(QuadrupedModelMuJoCoTest, SameDynamics) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1()}) {
    MuJoCo mujoco(robot);
    const QuadrupedModel model(robot);
    RandomStream random(21);
    QuadrupedDynamics dynamics;
    for (int i = 0; i < 100; ++i) {
      const LeggedState x = test::RandomState(random);
      const Vec<12> tau = test::RandomVector<12>(random, 30);
      mujoco.Calc(x, tau);
      model.Calc(x, &dynamics);
      Vec<18> force = -dynamics.bias();
      force.tail<12>() += tau;
      const Vec<18> a = dynamics.M.llt().solve(force);
      EXPECT_THAT(dynamics.M, IsNear(mujoco.M(), 1e-8));
      EXPECT_THAT(dynamics.bias(), IsNear(mujoco.Bias(), 1e-8));
      EXPECT_THAT(a, IsNear(mujoco.Acceleration(), 1e-8 * (1 + a.norm())));
    }
  }
}

}  // namespace
}  // namespace tenon
