#include <tenon/controllers/cdpr/kino_centroidal_model.h>

#include <fmt/core.h>
#include <tenon/plants/model/cross_matrix.h>
#include <tenon/plants/model/euler.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/systems/framework/errors.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tenon {
namespace {

/// How many of n cables are computed side by side.
template <int n>
constexpr int kBlock = n == Eigen::Dynamic ? 8 : n;

/// Of all cables, those of the block that begins with `first`.
template <int n>
int BlockSize(int cables, int first) {
  return n == Eigen::Dynamic ? std::min(kBlock<n>, cables - first) : n;
}

}  // namespace

CentroidalState CentroidalStateOf(const LoadedPlatform& body, const Eigen::Vector3d& p_WB,
                                  const Eigen::Matrix3d& R_WB, const Eigen::Vector3d& euler,
                                  const Eigen::Vector3d& v_W, const Eigen::Vector3d& w_W) {
  const Eigen::Vector3d arm_W = R_WB * body.com_B;
  CentroidalState x;
  x << v_W + w_W.cross(arm_W), R_WB * body.inertia * R_WB.transpose() * w_W / body.mass, p_WB + arm_W, euler;
  return x;
}

CentroidalState CentroidalStateOf(const CdprDescription& robot, const PlatformState& platform,
                                  const Payload& payload) {
  const Eigen::Matrix3d R_WB = platform.R_WB();
  return CentroidalStateOf(LoadedPlatform(robot, payload), platform.p_WB, R_WB, EulerFromRotation(R_WB),
                           platform.v_W, platform.w_W);
}

Eigen::Matrix<double, 12, 12> ErrorsOfPlatform(const CdprDescription& robot, const LoadedPlatform& body,
                                               const Eigen::Vector3d& euler) {
  const Eigen::Matrix3d R_WB = RotationFromEuler(euler);
  const Eigen::Matrix3d cross = CrossMatrix(R_WB * body.com_B);
  const Eigen::Matrix3d rate = R_WB * (body.mass * body.inertia.inverse()) * R_WB.transpose();  // w = rate L
  Eigen::Matrix<double, 12, 12> T = Eigen::Matrix<double, 12, 12>::Identity();
  T.block<3, 3>(0, 3) = cross * rate;  // v = v' - w x c
  T.block<3, 3>(3, 3) = R_WB * robot.inertia_B * R_WB.transpose() / robot.mass * rate;
  T.block<3, 3>(6, 9) = cross * EulerRateMatrix(euler);  // p = p' - c
  return T;
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
  if (n != Eigen::Dynamic && robot.num_cables() != n)
    throw ParameterError(fmt::format("the model is made for {} cables but the robot '{}' has {}", n,
                                     robot.name, robot.num_cables()));
  anchor_W_.resize(3, robot.num_cables());
  attachment_B_.resize(3, robot.num_cables());
  for (int i = 0; i < robot.num_cables(); ++i) {
    anchor_W_.col(i) = robot.cables[i].anchor_W;
    attachment_B_.col(i) = robot.cables[i].attachment_B;
  }
}

template <int n>
void KinoCentroidalModel<n>::SetPayload(const CdprDescription& robot, const LoadedPlatform& body) {
  mass_inverse_ = 1 / body.mass;
  inertia_inverse_ = body.mass * body.inertia.inverse();
  for (int i = 0; i < robot.num_cables(); ++i)
    attachment_B_.col(i) = robot.cables[static_cast<std::size_t>(i)].attachment_B - body.com_B;
}

template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::Derivative(const State& x, const Input& u, State& dx) const {
  const Attitude attitude(x.template tail<3>());
  Eigen::Vector3d force = load.head<3>(), torque = load.tail<3>();
  int first = 0;
  do {
    const int size = BlockSize<n>(num_inputs(), first);
    double pull[6][kBlock<n>];
    for (int i = 0; i < size; ++i) {
      double a[3], d[3];
      for (int r = 0; r < 3; ++r) {
        a[r] = attitude.R(r, 0) * attachment_B_(0, first + i) +
               attitude.R(r, 1) * attachment_B_(1, first + i) +
               attitude.R(r, 2) * attachment_B_(2, first + i);
        d[r] = anchor_W_(r, first + i) - x[6 + r] - a[r];
      }
      const double scale = u[first + i] / std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      for (int r = 0; r < 3; ++r) pull[r][i] = scale * d[r];
      pull[3][i] = a[1] * pull[2][i] - a[2] * pull[1][i];
      pull[4][i] = a[2] * pull[0][i] - a[0] * pull[2][i];
      pull[5][i] = a[0] * pull[1][i] - a[1] * pull[0][i];
    }
    for (int r = 0; r < 3; ++r) {
      for (int i = 0; i < size; ++i) {
        force[r] += pull[r][i];
        torque[r] += pull[3 + r][i];
      }
    }
    first += size;
  } while (n == Eigen::Dynamic && first < num_inputs());  // once if n is a constant
  dx.template head<3>() = mass_inverse_ * force;
  dx[2] -= kGravity;
  dx.template segment<3>(3) = mass_inverse_ * torque;
  dx.template segment<3>(6) = x.template head<3>();
  const Eigen::Vector3d momentum_B = attitude.R.transpose() * x.template segment<3>(3);
  const Eigen::Vector3d rate_B = inertia_inverse_ * momentum_B;
  dx.template tail<3>() = attitude.EulerRate(attitude.R * rate_B);
}

template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::Linearization::Multiply(const Tangent& tangent,
                                                                         Tangent& rate) const {
  // The blocks by columns, filled up to whole vectors.
  double J[6][8] = {}, G[6][4] = {};
  for (int k = 0; k < 6; ++k)
    for (int r = 0; r < 6; ++r) J[k][r] = momentum_by_pose(r, k);
  for (int k = 0; k < 3; ++k) {
    for (int r = 0; r < 3; ++r) {
      G[k][r] = euler_by_momentum(r, k);
      G[3 + k][r] = euler_by_euler(r, k);
    }
  }
  const double* S = tangent.data();
  double* K = rate.data();
  for (int j = 0; j < 12 + cables(); ++j, S += 12, K += 12) {
    double momentum[8] = {}, euler[4] = {};
    for (int k = 0; k < 6; ++k) {
      for (int r = 0; r < 8; ++r) momentum[r] += J[k][r] * S[6 + k];
      for (int r = 0; r < 4; ++r) euler[r] += G[k][r] * S[k < 3 ? 3 + k : 6 + k];
    }
    if (j >= 12)
      for (int r = 0; r < 6; ++r) momentum[r] += momentum_by_tension(r, j - 12);
    for (int r = 0; r < 6; ++r) K[r] = momentum[r];
    for (int r = 0; r < 3; ++r) {
      K[6 + r] = S[r];
      K[9 + r] = euler[r];
    }
  }
}

// With a the arm, d the direction, m = a x d, u the tension, s = u / l, the derivatives of the wrench of a
// cable by p and by a rotation vector in W (see CalcWrenchJacobian() in cdpr_kinematics.h) become
//     df/dp     = -s (1 - d d^T)
//     df/dtheta =  s ([a x] + d m^T),   dtau/dp its transpose
//     dtau/dtheta = s (a a^T + m m^T) + u a d^T - (s |a|^2 + u a.d) 1
template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::Linearize(const State& x, const Input& u, State& dx,
                                                           Linearization& f) const {
  const Attitude attitude(x.template tail<3>());
  const double cp = attitude.cp, sp = attitude.sp, cy = attitude.cy, sy = attitude.sy;
  Eigen::Vector3d force = load.head<3>(), torque = load.tail<3>(), lever = Eigen::Vector3d::Zero();
  Eigen::Matrix3d force_by_p = Eigen::Matrix3d::Zero(), force_by_turn = force_by_p,
                  torque_by_turn = force_by_p;
  double stiffness = 0, trace = 0;
  int first = 0;
  do {
    const int size = BlockSize<n>(num_inputs(), first);
    double a[3][kBlock<n>], d[3][kBlock<n>], m[3][kBlock<n>], t[kBlock<n>], s[kBlock<n>], mixed[kBlock<n>];
    for (int i = 0; i < size; ++i) {
      for (int r = 0; r < 3; ++r) {
        a[r][i] = attitude.R(r, 0) * attachment_B_(0, first + i) +
                  attitude.R(r, 1) * attachment_B_(1, first + i) +
                  attitude.R(r, 2) * attachment_B_(2, first + i);
        d[r][i] = anchor_W_(r, first + i) - x[6 + r] - a[r][i];
      }
      const double inverse = 1 / std::sqrt(d[0][i] * d[0][i] + d[1][i] * d[1][i] + d[2][i] * d[2][i]);
      for (int r = 0; r < 3; ++r) d[r][i] *= inverse;
      t[i] = u[first + i];
      s[i] = t[i] * inverse;
      m[0][i] = a[1][i] * d[2][i] - a[2][i] * d[1][i];
      m[1][i] = a[2][i] * d[0][i] - a[0][i] * d[2][i];
      m[2][i] = a[0][i] * d[1][i] - a[1][i] * d[0][i];
      mixed[i] = s[i] * (a[0][i] * a[0][i] + a[1][i] * a[1][i] + a[2][i] * a[2][i]) +
                 t[i] * (a[0][i] * d[0][i] + a[1][i] * d[1][i] + a[2][i] * d[2][i]);
    }
    const auto sum = [size](const auto& term) {
      double total = 0;
      for (int i = 0; i < size; ++i) total += term(i);
      return total;
    };
    stiffness += sum([&](int i) { return s[i]; });
    trace += sum([&](int i) { return mixed[i]; });
    for (int r = 0; r < 3; ++r) {
      force[r] += sum([&](int i) { return t[i] * d[r][i]; });
      torque[r] += sum([&](int i) { return t[i] * m[r][i]; });
      lever[r] += sum([&](int i) { return s[i] * a[r][i]; });
      for (int c = 0; c < 3; ++c) {
        force_by_turn(r, c) += sum([&](int i) { return s[i] * d[r][i] * m[c][i]; });
        torque_by_turn(r, c) += sum(
            [&](int i) { return s[i] * (a[r][i] * a[c][i] + m[r][i] * m[c][i]) + t[i] * a[r][i] * d[c][i]; });
        if (c <= r) force_by_p(r, c) += sum([&](int i) { return s[i] * d[r][i] * d[c][i]; });
      }
      for (int i = 0; i < size; ++i) {
        f.momentum_by_tension(r, first + i) = mass_inverse_ * d[r][i];
        f.momentum_by_tension(3 + r, first + i) = mass_inverse_ * m[r][i];
      }
    }
    first += size;
  } while (n == Eigen::Dynamic && first < num_inputs());  // once if n is a constant
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < r; ++c) force_by_p(c, r) = force_by_p(r, c);
    force_by_p(r, r) -= stiffness;
    torque_by_turn(r, r) -= trace;
  }
  force_by_turn += CrossMatrix(lever);
  const Eigen::Matrix3d torque_by_p = force_by_turn.transpose();

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
  const Eigen::Matrix3d w_by_euler = (mobility * CrossMatrix(momentum) - CrossMatrix(w)) * E;
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
template class KinoCentroidalModel<Eigen::Dynamic>;

}  // namespace tenon
