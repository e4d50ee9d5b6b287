#include "tenon/controllers/kino_centroidal_model.h"

#include <fmt/core.h>
#include <tenon/plants/description/euler.h>
#include <tenon/systems/errors.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace tenon {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d cross;
  cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return cross;
}

}  // namespace

CentroidalState CentroidalStateOf(const CdprDescription& robot, const PlatformState& platform) {
  const Eigen::Matrix3d R_WB = platform.R_WB();
  CentroidalState x;
  x << platform.v_W, R_WB * robot.inertia_B * R_WB.transpose() * platform.w_W / robot.mass, platform.p_WB,
      EulerFromRotation(R_WB);
  return x;
}

template <int n>
struct KinoCentroidalModel<n>::Attitude {
  double sr, cr, sp, cp, sy, cy;
  Eigen::Matrix3d R;

  explicit Attitude(const Eigen::Vector3d& euler)
      : sr(std::sin(euler[0])),
        cr(std::cos(euler[0])),
        sp(std::sin(euler[1])),
        cp(std::cos(euler[1])),
        sy(std::sin(euler[2])),
        cy(std::cos(euler[2])) {
    R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
        -sp, cp * sr, cp * cr;
  }
  /// E^{-1} a.
  Eigen::Vector3d EulerRate(const Eigen::Vector3d& a) const {
    const double roll = (cy * a[0] + sy * a[1]) / cp;
    return {roll, cy * a[1] - sy * a[0], a[2] + sp * roll};
  }
};

template <int n>
KinoCentroidalModel<n>::KinoCentroidalModel(const CdprDescription& robot)
    : mass_inverse_(1 / robot.mass), inertia_inverse_(robot.mass * robot.inertia_B.inverse()) {
  if (robot.num_cables() != n)
    throw ParameterError(fmt::format("the model is made for {} cables but the robot '{}' has {}", n,
                                     robot.name, robot.num_cables()));
  for (int i = 0; i < n; ++i) {
    anchor_W_[i] = robot.cables[i].anchor_W;
    attachment_B_[i] = robot.cables[i].attachment_B;
  }
}

template <int n>
void KinoCentroidalModel<n>::Derivative(const State& x, const Input& u, State& dx) const {
  const Attitude attitude(x.template tail<3>());
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d arm = attitude.R * attachment_B_[i];
    const Eigen::Vector3d span = anchor_W_[i] - x.template segment<3>(6) - arm;
    const Eigen::Vector3d pull = (u[i] / std::sqrt(span.squaredNorm())) * span;
    force += pull;
    torque += arm.cross(pull);
  }
  dx.template head<3>() = mass_inverse_ * force;
  dx[2] -= kGravity;
  dx.template segment<3>(3) = mass_inverse_ * torque;
  dx.template segment<3>(6) = x.template head<3>();
  const Eigen::Vector3d momentum_B = attitude.R.transpose() * x.template segment<3>(3);
  const Eigen::Vector3d rate_B = inertia_inverse_ * momentum_B;
  dx.template tail<3>() = attitude.EulerRate(attitude.R * rate_B);
}

template <int n>
void KinoCentroidalModel<n>::Linearize(const State& x, const Input& u, State& dx, Linearization& f) const {
  const Attitude attitude(x.template tail<3>());
  const double cp = attitude.cp, sp = attitude.sp, cy = attitude.cy, sy = attitude.sy;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  // By p and by a rotation vector in W: see CalcWrenchJacobian() in cdpr_kinematics.h.
  Eigen::Matrix3d force_by_p = Eigen::Matrix3d::Zero(), force_by_turn = force_by_p, torque_by_p = force_by_p,
                  torque_by_turn = force_by_p;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d arm = attitude.R * attachment_B_[i];
    const Eigen::Vector3d span = anchor_W_[i] - x.template segment<3>(6) - arm;
    const double inverse = 1 / std::sqrt(span.squaredNorm());
    const Eigen::Vector3d direction = inverse * span;
    const Eigen::Vector3d moment = arm.cross(direction);
    force += u[i] * direction;
    torque += u[i] * moment;
    f.momentum_by_tension.col(i) << mass_inverse_ * direction, mass_inverse_ * moment;

    // turn = (u / l) (1 - direction direction^T), and its products with [arm x].
    const double stiffness = u[i] * inverse;
    Eigen::Matrix3d turn = -stiffness * direction * direction.transpose();
    turn.diagonal().array() += stiffness;
    const Eigen::Matrix3d skew = Skew(arm);
    const Eigen::Matrix3d turn_arm = turn * skew;
    force_by_p -= turn;
    force_by_turn += turn_arm;
    torque_by_turn += skew * turn_arm + arm * (u[i] * direction).transpose();
    torque_by_turn.diagonal().array() -= u[i] * direction.dot(arm);
  }
  torque_by_p = force_by_turn.transpose();

  dx.template head<3>() = mass_inverse_ * force;
  dx[2] -= kGravity;
  dx.template segment<3>(3) = mass_inverse_ * torque;
  dx.template segment<3>(6) = x.template head<3>();

  const Eigen::Matrix3d mobility = attitude.R * inertia_inverse_ * attitude.R.transpose();
  const Eigen::Vector3d momentum = x.template segment<3>(3);
  const Eigen::Vector3d w = mobility * momentum;
  dx.template tail<3>() = attitude.EulerRate(w);

  Eigen::Matrix3d E;  // EulerRateMatrix()
  E << cy * cp, -sy, 0, sy * cp, cy, 0, -sp, 0, 1;
  f.momentum_by_pose.template topLeftCorner<3, 3>() = mass_inverse_ * force_by_p;
  f.momentum_by_pose.template topRightCorner<3, 3>().noalias() = mass_inverse_ * (force_by_turn * E);
  f.momentum_by_pose.template bottomLeftCorner<3, 3>() = mass_inverse_ * torque_by_p;
  f.momentum_by_pose.template bottomRightCorner<3, 3>().noalias() = mass_inverse_ * (torque_by_turn * E);

  // dw = (mobility [L x] - [w x]) dturn, at constant L; E^{-1} w depends on pitch and yaw besides.
  const Eigen::Matrix3d w_by_euler = (mobility * Skew(momentum) - Skew(w)) * E;
  for (int c = 0; c < 3; ++c) {
    f.euler_by_momentum.col(c) = attitude.EulerRate(mobility.col(c));
    f.euler_by_euler.col(c) = attitude.EulerRate(w_by_euler.col(c));
  }
  const double along = cy * w[0] + sy * w[1], across = cy * w[1] - sy * w[0];
  f.euler_by_euler.col(1) += Eigen::Vector3d(along * sp, 0, along) / (cp * cp);
  f.euler_by_euler.col(2) += Eigen::Vector3d(across / cp, -along, across * sp / cp);
}

template class KinoCentroidalModel<4>;
template class KinoCentroidalModel<5>;
template class KinoCentroidalModel<6>;
template class KinoCentroidalModel<7>;
template class KinoCentroidalModel<8>;

}  // namespace tenon
