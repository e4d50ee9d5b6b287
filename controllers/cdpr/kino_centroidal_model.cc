#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/cdpr/kino_centroidal_model.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon {
namespace {

using internal::Lanes;
using internal::LoadFirst;
using internal::PacketAt;
using internal::Padded;
using internal::SinCos;
using internal::Sqrt;
using internal::Transpose;

/// The attitude of one platform, or of four platforms in Lanes.
template <class T>
struct Attitude {
  T sr, cr, sp, cp, sy, cy, cp_inverse;
  T R[3][3];

  [[gnu::always_inline]] Attitude(const T (&sine)[3], const T (&cosine)[3])
      : sr(sine[0]),
        cr(cosine[0]),
        sp(sine[1]),
        cp(cosine[1]),
        sy(sine[2]),
        cy(cosine[2]),
        cp_inverse(1 / cp) {
    R[0][0] = cy * cp;
    R[0][1] = cy * sp * sr - sy * cr;
    R[0][2] = cy * sp * cr + sy * sr;
    R[1][0] = sy * cp;
    R[1][1] = sy * sp * sr + cy * cr;
    R[1][2] = sy * sp * cr - cy * sr;
    R[2][0] = -sp;
    R[2][1] = cp * sr;
    R[2][2] = cp * cr;
  }
  /// rate = E^{-1} w.
  [[gnu::always_inline]] void EulerRate(const T& w0, const T& w1, const T& w2, T* rate) const {
    const T roll = (cy * w0 + sy * w1) * cp_inverse;
    rate[0] = roll;
    rate[1] = cy * w1 - sy * w0;
    rate[2] = w2 + sp * roll;
  }
  /// a (a0, a1, a2)^T E, see EulerRateMatrix().
  [[gnu::always_inline]] void TimesE(const T (&a)[3], T* product) const {
    product[0] = (a[0] * cy + a[1] * sy) * cp - a[2] * sp;
    product[1] = a[1] * cy - a[0] * sy;
    product[2] = a[2];
  }
};

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
  const Eigen::Matrix3d rate =
      R_WB * (body.mass * internal::Inverse<3>(body.inertia)) * R_WB.transpose();  // w = rate L
  Eigen::Matrix<double, 12, 12> T = Eigen::Matrix<double, 12, 12>::Identity();
  T.block<3, 3>(0, 3) = cross * rate;  // v = v' - w x c
  T.block<3, 3>(3, 3) = R_WB * robot.inertia_B * R_WB.transpose() / robot.mass * rate;
  T.block<3, 3>(6, 9) = cross * EulerRateMatrix(euler);  // p = p' - c
  return T;
}

template <int n>
KinoCentroidalModel<n>::KinoCentroidalModel(const CdprDescription& robot) : cables_(robot.num_cables()) {
  if (n != Eigen::Dynamic && cables_ != n)
    throw ParameterError(
        fmt::format("the model is made for {} cables but the robot '{}' has {}", n, robot.name, cables_));
  // Cables that only pad the registers are far away, which avoids divisions by zero, and never pull.
  anchor_W_.setConstant(Padded(cables_), 3, 1e6);
  attachment_B_.setZero(anchor_W_.rows(), 3);
  for (int i = 0; i < cables_; ++i) anchor_W_.row(i) = robot.cables[i].anchor_W.transpose();
  gravity_ = robot.on_table ? 0 : kGravity;
  SetPayload(robot, {robot, {}});
}

template <int n>
void KinoCentroidalModel<n>::SetPayload(const CdprDescription& robot, const LoadedPlatform& body) {
  mass_inverse_ = 1 / body.mass;
  com_B_ = body.com_B;
  inertia_inverse_ = body.mass * internal::Inverse<3>(body.inertia);
  for (int i = 0; i < robot.num_cables(); ++i)
    attachment_B_.row(i) = (robot.cables[i].attachment_B - body.com_B).transpose();
  springs_ = robot.springs;
  for (SpringDescription& spring : springs_) spring.attachment_B -= body.com_B;
}

template <int n>
void KinoCentroidalModel<n>::SetPose(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                     const Eigen::Matrix3d& R_WB) {
  if (robot.has_pulleys()) SetAnchors(0, robot, {}, 0, p_WB, R_WB);
}

template <int n>
void KinoCentroidalModel<n>::SetAnchors(int k, const CdprDescription& robot, const MovingAnchors& anchors,
                                        double time, const Eigen::Vector3d& p_WB,
                                        const Eigen::Matrix3d& R_WB) {
  for (int i = 0; i < robot.num_cables(); ++i) {
    const CableLine line = CalcCableLine(robot, i, p_WB, R_WB, anchors, time);
    anchor_W_.row(i).segment(3 * k, 3) = line.exit_W.transpose();
    if (k == 0 && robot.carries_pulley(i))
      attachment_B_.row(i) = (R_WB.transpose() * line.arm_W - com_B_).transpose();
  }
}

template <int n>
Eigen::Matrix<double, 6, 1> KinoCentroidalModel<n>::RatesBySprings(
    const Eigen::Vector3d& p_W, const Eigen::Vector3d& euler, Eigen::Matrix<double, 6, 6>* by_pose) const {
  const auto wrench = CalcSpringWrench(springs_, p_W, RotationFromEuler(euler), by_pose);
  if (by_pose) {
    *by_pose *= mass_inverse_;
    by_pose->template rightCols<3>() = (by_pose->template rightCols<3>() * EulerRateMatrix(euler)).eval();
  }
  return mass_inverse_ * wrench;
}

/// Computes f(x, u) with the anchors in the columns from `column` on, with the state and its rate in three
/// registers, of which the second begins within L.
template <int n>
TENON_INLINE void KinoCentroidalModel<n>::CalcRate(Eigen::Index column, const Lanes (&x)[3], const double* u,
                                                   Lanes (&dx)[3]) const {
  Lanes sine, cosine;
  SinCos(x[2], &sine, &cosine);
  const Attitude<double> attitude({sine[1], sine[2], sine[3]}, {cosine[1], cosine[2], cosine[3]});
  const auto& R = attitude.R;
  const Eigen::Index padded = anchor_W_.rows();
  Lanes sums[2][4] = {};  // force and torque, each with one lane per cable
  for (Eigen::Index first = 0; first < padded; first += 4) {
    Lanes arm[3], pull[3];
    for (int r = 0; r < 3; ++r) {
      arm[r] = R[r][0] * *PacketAt(&attachment_B_(first, 0)) + R[r][1] * *PacketAt(&attachment_B_(first, 1)) +
               R[r][2] * *PacketAt(&attachment_B_(first, 2));
      const double p = r == 0 ? x[1][2] : r == 1 ? x[1][3] : x[2][0];
      pull[r] = *PacketAt(&anchor_W_(first, column + r)) - p - arm[r];
    }
    Lanes length, scale;
    Sqrt(pull[0] * pull[0] + pull[1] * pull[1] + pull[2] * pull[2], &length);
    LoadFirst(u + first, num_inputs() - static_cast<int>(first), &scale);
    scale /= length;
    for (int r = 0; r < 3; ++r) {
      pull[r] *= scale;
      sums[0][r] += pull[r];
    }
    sums[0][3] += arm[1] * pull[2] - arm[2] * pull[1];
    sums[1][0] += arm[2] * pull[0] - arm[0] * pull[2];
    sums[1][1] += arm[0] * pull[1] - arm[1] * pull[0];
  }
  for (Lanes(&rows)[4] : sums) Transpose(rows);
  const Lanes load_0{load[0], load[1], load[2], load[3]}, load_1{load[4], load[5], 0, 0};
  const Lanes a = (load_0 + ((sums[0][0] + sums[0][1]) + (sums[0][2] + sums[0][3]))) * mass_inverse_;
  const Lanes b = (load_1 + ((sums[1][0] + sums[1][1]) + (sums[1][2] + sums[1][3]))) * mass_inverse_;

  const double L[3] = {x[0][3], x[1][0], x[1][1]};
  double L_B[3], w_B[3], w[3], rate[3];
  for (int c = 0; c < 3; ++c) L_B[c] = R[0][c] * L[0] + R[1][c] * L[1] + R[2][c] * L[2];
  for (int r = 0; r < 3; ++r)
    w_B[r] =
        inertia_inverse_(r, 0) * L_B[0] + inertia_inverse_(r, 1) * L_B[1] + inertia_inverse_(r, 2) * L_B[2];
  for (int r = 0; r < 3; ++r) w[r] = R[r][0] * w_B[0] + R[r][1] * w_B[1] + R[r][2] * w_B[2];
  attitude.EulerRate(w[0], w[1], w[2], rate);
  dx[0] = a - Lanes{0, 0, gravity_, 0};
  dx[1] = Lanes{b[0], b[1], x[0][0], x[0][1]};
  dx[2] = Lanes{x[0][2], rate[0], rate[1], rate[2]};
  if (springs_.empty()) return;
  const Eigen::Matrix<double, 6, 1> f =
      RatesBySprings({x[1][2], x[1][3], x[2][0]}, {x[2][1], x[2][2], x[2][3]}, nullptr);
  dx[0] += Lanes{f[0], f[1], f[2], f[3]};
  dx[1] += Lanes{f[4], f[5], 0, 0};
}

template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::Derivative(const State& x, const Input& u, State& dx) const {
  const Lanes at[3] = {*PacketAt(&x[0]), *PacketAt(&x[4]), *PacketAt(&x[8])};
  Lanes k[3] = {};
  CalcRate(0, at, u.data(), k);
  for (int j = 0; j < 3; ++j) *PacketAt(&dx[4 * j]) = k[j];
}

template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::Step(int node, StepMethod method, double h, const State& x,
                                                      const Input& u, State& next) const {
  const StepTableau& tableau = TableauOf(method);
  const Lanes start[3] = {*PacketAt(&x[0]), *PacketAt(&x[4]), *PacketAt(&x[8])};
  Lanes at[3] = {start[0], start[1], start[2]}, end[3] = {start[0], start[1], start[2]}, k[3] = {};
  for (int i = 0; i < tableau.stages; ++i) {
    if (i > 0)
      for (int j = 0; j < 3; ++j) at[j] = start[j] + (tableau.a[i] * h) * k[j];
    CalcRate(ColumnOf(node), at, u.data(), k);
    for (int j = 0; j < 3; ++j) end[j] += (tableau.b[i] * h) * k[j];
  }
  for (int j = 0; j < 3; ++j) *PacketAt(&next[4 * j]) = end[j];
}

/// The Jacobians of f in blocks, column by column, at four nodes. All other entries are zero, except
/// d(dp/dt)/dv = 1.
template <int n>
struct KinoCentroidalModel<n>::Stage {
  Lanes momentum_by_pose[6][6];   ///< rows v, L; columns p, Theta
  Lanes euler_by_momentum[3][3];  ///< d(dTheta/dt)/dL
  Lanes euler_by_euler[3][3];     ///< d(dTheta/dt)/dTheta
};

// With the arm a, the direction d, m = a x d, the tension u and s = u / l, the derivatives of a cable's
// wrench with respect to p and to a rotation vector in W (see CalcWrenchJacobian() in cdpr_kinematics.h)
// become
//     df/dp     = -s (1 - d d^T)
//     df/dtheta =  s ([a x] + d m^T),   dtau/dp its transpose
//     dtau/dtheta = s m m^T + M - trace(M) 1,   M = a (s a + u d)^T
// `u` holds a cable's tensions at the four nodes `node`; `wrench` receives its d(rate of v, L)/du.
template <int n>
template <class Tension, class Wrench>
TENON_INLINE void KinoCentroidalModel<n>::LinearizeFour(const int (&node)[4], const Lanes (&x)[12],
                                                        const Tension& u, Lanes (&dx)[12], Stage& f,
                                                        const Wrench& wrench) const {
  Lanes sine[3], cosine[3];
  for (int r = 0; r < 3; ++r) SinCos(x[9 + r], &sine[r], &cosine[r]);
  const Attitude<Lanes> attitude(sine, cosine);
  const auto& R = attitude.R;
  Lanes force[3], torque[3], lever[3] = {}, force_by_p[3][3] = {}, force_by_turn[3][3] = {}, of_m[3][3] = {},
                             of_a[3][3] = {};
  for (int r = 0; r < 3; ++r) {
    force[r] = Lanes{} + load[r];
    torque[r] = Lanes{} + load[3 + r];
  }
  const bool moving = anchor_W_.cols() > 3;
  for (int i = 0; i < num_inputs(); ++i) {
    Lanes a[3], d[3];
    for (int r = 0; r < 3; ++r) {
      a[r] = R[r][0] * attachment_B_(i, 0) + R[r][1] * attachment_B_(i, 1) + R[r][2] * attachment_B_(i, 2);
      d[r] = Lanes{} + anchor_W_(i, r);
      if (moving)
        d[r] = Lanes{anchor_W_(i, 3 * node[0] + r), anchor_W_(i, 3 * node[1] + r),
                     anchor_W_(i, 3 * node[2] + r), anchor_W_(i, 3 * node[3] + r)};
      d[r] = d[r] - x[6 + r] - a[r];
    }
    Lanes length, t;
    Sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], &length);
    const Lanes inverse = 1 / length;
    for (int r = 0; r < 3; ++r) d[r] *= inverse;
    u(i, &t);
    const Lanes s = t * inverse;
    const Lanes m[3] = {a[1] * d[2] - a[2] * d[1], a[2] * d[0] - a[0] * d[2], a[0] * d[1] - a[1] * d[0]};
    double* const column = wrench(i);
    Lanes q[3];
    for (int r = 0; r < 3; ++r) {
      *PacketAt(column + 4 * r) = mass_inverse_ * d[r];
      *PacketAt(column + 4 * (3 + r)) = mass_inverse_ * m[r];
      const Lanes ta = s * a[r], td = t * d[r];
      force[r] += td;
      torque[r] += t * m[r];
      lever[r] += ta;
      q[r] = ta + td;
    }
    for (int r = 0; r < 3; ++r) {
      const Lanes sd = s * d[r], sm = s * m[r];
      for (int c = 0; c < 3; ++c) {
        force_by_turn[r][c] += sd * m[c];
        of_a[r][c] += a[r] * q[c];
        if (c <= r) force_by_p[r][c] += sd * d[c];
        if (c <= r) of_m[r][c] += sm * m[c];
      }
    }
  }
  // The traces: d has length one.
  const Lanes stiffness = force_by_p[0][0] + force_by_p[1][1] + force_by_p[2][2];
  const Lanes trace = of_a[0][0] + of_a[1][1] + of_a[2][2];
  Lanes torque_by_turn[3][3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) torque_by_turn[r][c] = of_a[r][c] + (c <= r ? of_m[r][c] : of_m[c][r]);
    torque_by_turn[r][r] -= trace;
    force_by_p[r][r] -= stiffness;
  }
  force_by_turn[0][1] -= lever[2];
  force_by_turn[0][2] += lever[1];
  force_by_turn[1][0] += lever[2];
  force_by_turn[1][2] -= lever[0];
  force_by_turn[2][0] -= lever[1];
  force_by_turn[2][1] += lever[0];
  for (int r = 0; r < 3; ++r) {
    dx[r] = mass_inverse_ * force[r];
    dx[3 + r] = mass_inverse_ * torque[r];
    dx[6 + r] = x[r];
    Lanes by_euler[2][3];
    attitude.TimesE(force_by_turn[r], by_euler[0]);
    attitude.TimesE(torque_by_turn[r], by_euler[1]);
    for (int c = 0; c < 3; ++c) {
      f.momentum_by_pose[c][r] = mass_inverse_ * (c <= r ? force_by_p[r][c] : force_by_p[c][r]);
      f.momentum_by_pose[c][3 + r] = mass_inverse_ * force_by_turn[c][r];
      f.momentum_by_pose[3 + c][r] = mass_inverse_ * by_euler[0][c];
      f.momentum_by_pose[3 + c][3 + r] = mass_inverse_ * by_euler[1][c];
    }
  }
  dx[2] -= gravity_;
  for (int l = 0; l < 4 && !springs_.empty(); ++l) {
    Eigen::Matrix<double, 6, 6> by_pose;
    const Eigen::Matrix<double, 6, 1> rates =
        RatesBySprings({x[6][l], x[7][l], x[8][l]}, {x[9][l], x[10][l], x[11][l]}, &by_pose);
    for (int r = 0; r < 6; ++r) {
      dx[r][l] += rates[r];
      for (int c = 0; c < 6; ++c) f.momentum_by_pose[c][r][l] += by_pose(r, c);
    }
  }

  const Lanes L[3] = {x[3], x[4], x[5]};
  Lanes mobility[3][3], w[3];
  for (int r = 0; r < 3; ++r) {
    Lanes RI[3];
    for (int c = 0; c < 3; ++c)
      RI[c] = R[r][0] * inertia_inverse_(0, c) + R[r][1] * inertia_inverse_(1, c) +
              R[r][2] * inertia_inverse_(2, c);
    for (int c = 0; c < 3; ++c) mobility[r][c] = RI[0] * R[c][0] + RI[1] * R[c][1] + RI[2] * R[c][2];
    w[r] = mobility[r][0] * L[0] + mobility[r][1] * L[1] + mobility[r][2] * L[2];
  }
  attitude.EulerRate(w[0], w[1], w[2], &dx[9]);

  // dw = (mobility [L x] - [w x]) dturn at constant L; E^{-1} w also depends on pitch and yaw.
  Lanes w_by_euler[3][3];
  for (int r = 0; r < 3; ++r) {
    const Lanes(&M)[3] = mobility[r];
    Lanes by_turn[3] = {M[1] * L[2] - M[2] * L[1], M[2] * L[0] - M[0] * L[2], M[0] * L[1] - M[1] * L[0]};
    by_turn[(r + 1) % 3] += w[(r + 2) % 3];
    by_turn[(r + 2) % 3] -= w[(r + 1) % 3];
    attitude.TimesE(by_turn, w_by_euler[r]);
  }
  for (int c = 0; c < 3; ++c) {
    attitude.EulerRate(mobility[0][c], mobility[1][c], mobility[2][c], f.euler_by_momentum[c]);
    attitude.EulerRate(w_by_euler[0][c], w_by_euler[1][c], w_by_euler[2][c], f.euler_by_euler[c]);
  }
  const Lanes along = (attitude.cy * w[0] + attitude.sy * w[1]) * attitude.cp_inverse;
  const Lanes across = (attitude.cy * w[1] - attitude.sy * w[0]) * attitude.cp_inverse;
  f.euler_by_euler[1][0] += along * attitude.sp * attitude.cp_inverse;
  f.euler_by_euler[1][2] += along * attitude.cp_inverse;
  f.euler_by_euler[2][0] += across;
  f.euler_by_euler[2][1] -= along * attitude.cp;
  f.euler_by_euler[2][2] += across * attitude.sp;
}

/// Computes a column of [dF/dx  dF/du] - [1  0] at four nodes: number `c` in the block of v, L, p or Theta (0
/// to 3), or of the tensions (4), for which `wrench` is d(rate of v, L)/du of all stages.
template <int n>
template <int block>
TENON_INLINE void KinoCentroidalModel<n>::CalcColumn(const Stage* stages, const StepTableau& tableau,
                                                     const Lanes& h, int c, const double* wrench,
                                                     Lanes (&sum)[12]) {
  // K_i = fx e_c + fx (a_i h K_{i-1}), e_c the unit vector; the first term is a column of fx.
  Lanes K[12], S[12];
  const auto first = [&](const Stage& f, const double* of_cable) __attribute__((always_inline)) {
    for (int r = 0; r < 6; ++r) {
      K[r] = Lanes{};
      if constexpr (block == 2) K[r] = f.momentum_by_pose[c][r];
      if constexpr (block == 3) K[r] = f.momentum_by_pose[3 + c][r];
      if constexpr (block == 4) K[r] = *PacketAt(of_cable + 4 * r);
    }
    for (int r = 0; r < 3; ++r) {
      K[6 + r] = Lanes{} + (block == 0 && r == c ? 1.0 : 0.0);
      K[9 + r] = Lanes{};
      if constexpr (block == 1) K[9 + r] = f.euler_by_momentum[c][r];
      if constexpr (block == 3) K[9 + r] = f.euler_by_euler[c][r];
    }
  };
  // The remaining rows, in which S is not zero.
  const auto add = [&](const Stage& f, auto by_L, auto by_p, auto by_theta) __attribute__((always_inline)) {
    for (int k = 0; k < 3; ++k) {
      for (int r = 0; r < 6; ++r) {
        if constexpr (by_p()) K[r] += f.momentum_by_pose[k][r] * S[6 + k];
        if constexpr (by_theta()) K[r] += f.momentum_by_pose[3 + k][r] * S[9 + k];
      }
      for (int r = 0; r < 3; ++r) {
        if constexpr (by_L()) K[9 + r] += f.euler_by_momentum[k][r] * S[3 + k];
        if constexpr (by_theta()) K[9 + r] += f.euler_by_euler[k][r] * S[9 + k];
      }
      K[6 + k] += S[k];
    }
  };
  first(stages[0], wrench);
  for (int r = 0; r < 12; ++r) sum[r] = (tableau.b[0] * h) * K[r];
  constexpr auto yes = std::true_type();
  for (int i = 1; i < tableau.stages; ++i) {
    const Lanes scale = tableau.a[i] * h, weight = tableau.b[i] * h;
    for (int r = 0; r < 12; ++r) S[r] = scale * K[r];
    first(stages[i], block == 4 ? wrench + 24 * i : nullptr);
    if (i == 1) {
      add(stages[i], std::bool_constant<(block >= 2)>(), std::bool_constant<block == 0>(),
          std::bool_constant<(block == 1 || block == 3)>());
    } else {
      add(stages[i], yes, yes, yes);
    }
    for (int r = 0; r < 12; ++r) sum[r] += weight * K[r];
  }
}

template <int n>
TENON_VECTOR_CLONES void KinoCentroidalModel<n>::LinearizeSteps(StepMethod method, int count, const double* h,
                                                                const State* x, const Input* u,
                                                                Tangent* tangents,
                                                                StepWorkspace& workspace) const {
  const StepTableau& tableau = TableauOf(method);
  const int cables = num_inputs();
  Stage stages[StepTableau::kMaxStages];
  for (int begin = 0; begin < count; begin += 4) {
    // If less than four nodes are left, the last one is computed several times.
    int node[4];
    for (int l = 0; l < 4; ++l) node[l] = std::min(begin + l, count - 1);
    const Lanes step{h[node[0]], h[node[1]], h[node[2]], h[node[3]]};
    Lanes start[12], at[12], k[12] = {};
    for (int j = 0; j < 12; j += 4) {
      Lanes rows[4];
      for (int l = 0; l < 4; ++l) rows[l] = *PacketAt(&x[node[l]][j]);
      Transpose(rows);
      for (int l = 0; l < 4; ++l) start[j + l] = at[j + l] = rows[l];
    }
    for (int i = 0; i < tableau.stages; ++i) {
      if (i > 0)
        for (int j = 0; j < 12; ++j) at[j] = start[j] + (tableau.a[i] * step) * k[j];
      LinearizeFour(
          node, at,
          [&](int cable, Lanes* tensions) __attribute__((always_inline)) {
            *tensions = Lanes{u[node[0]][cable], u[node[1]][cable], u[node[2]][cable], u[node[3]][cable]};
          },
          k, stages[i],
          [&](int cable)
              __attribute__((always_inline)) { return workspace.wrench.col(cable).data() + 24 * i; });
    }
    const auto store = [&](int column, Lanes(&sum)[12]) __attribute__((always_inline)) {
      for (int j = 0; j < 12; j += 4) {
        Lanes rows[4] = {sum[j], sum[j + 1], sum[j + 2], sum[j + 3]};
        Transpose(rows);
        for (int l = 0; l < 4; ++l) *PacketAt(tangents[node[l]].data() + 12 * column + j) = rows[l];
      }
    };
    Lanes sum[12];
    for (int c = 0; c < 3; ++c) {
      CalcColumn<0>(stages, tableau, step, c, nullptr, sum);
      store(c, sum);
      CalcColumn<1>(stages, tableau, step, c, nullptr, sum);
      store(3 + c, sum);
      CalcColumn<2>(stages, tableau, step, c, nullptr, sum);
      store(6 + c, sum);
      CalcColumn<3>(stages, tableau, step, c, nullptr, sum);
      store(9 + c, sum);
    }
    for (int c = 0; c < cables; ++c) {
      CalcColumn<4>(stages, tableau, step, c, workspace.wrench.col(c).data(), sum);
      store(12 + c, sum);
    }
    for (int l = 0; l < 4 && begin + l < count; ++l)
      for (int r = 0; r < 12; ++r) tangents[begin + l](r, r) += 1;
  }
}

template class KinoCentroidalModel<4>;
template class KinoCentroidalModel<8>;
template class KinoCentroidalModel<Eigen::Dynamic>;

}  // namespace tenon
