#include <tenon/controllers/cdpr/balanced_reference.h>

#include <tenon/plants/model/euler.h>
#include <tenon/plants/model/quaternion.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenon {
namespace {

constexpr double kTurnScale = 1e-3;   // a turn of so many rad counts as much as 1 N
constexpr double kLargestStep = 0.1;  // of one call [rad]
constexpr double kLargestTurn = 1.2;  // altogether: beyond, cables cross [rad]

Eigen::Matrix3d RotationBy(const Eigen::Vector3d& turn) {
  return RotationFromQuaternion(QuaternionFromRotationVector(turn));
}

}  // namespace

void BalancedReference::Calc(const CdprReference& at, const LoadEstimate& load, ReferenceShift& shift) {
  const bool loaded = load.any();
  if (!loaded || shift.tension.size() != at.tension.size()) {
    shift.turn_W.setZero();
    shift.tension.setZero(at.tension.size());
  }
  tension_ = at.tension + shift.tension;
  R_WB_ = RotationFromEuler(at.euler);
  if (loaded) R_WB_ = RotationBy(shift.turn_W) * R_WB_;
  CalcCableKinematics(robot_, at.position, R_WB_, &cables_);

  // Newton's step on the equation, with the multiplier of the conditions of least change:
  // change = J^T multiplier, J J^T multiplier = J change_before - residual.
  Eigen::Matrix<double, 6, 3> by_turn = kTurnScale * CalcWrenchJacobian(cables_, tension_).rightCols<3>();
  Vector6d wanted = Vector6d::Zero();
  wanted.head<3>() = robot_.mass * at.acceleration;
  if (loaded) {
    const Eigen::Vector3d arm_W = R_WB_ * load.payload.p_B;
    const Eigen::Vector3d carried =
        load.payload.mass * (Eigen::Vector3d(0, 0, GravityWrench(robot_)[2] / robot_.mass) - at.acceleration);
    // d(arm x carried) of a turn t is (t x arm) x carried.
    by_turn.bottomRows<3>() +=
        kTurnScale * (arm_W * carried.transpose() - carried.dot(arm_W) * Eigen::Matrix3d::Identity());
    wanted -= GravityWrench(robot_);
    wanted.head<3>() -= carried + load.rest.force_W;
    wanted.tail<3>() -= arm_W.cross(carried) + load.rest.torque_W;
    wanted.noalias() += by_turn * (shift.turn_W / kTurnScale);
    wanted.noalias() -= cables_.structure * at.tension;
  }
  // Tensions beyond a bound are held there, and the others change more; as many as there are to spare.
  Vector6d multiplier;
  const Eigen::Index cables = at.tension.size();
  held_.assign(static_cast<std::size_t>(cables), 0);
  for (Eigen::Index spare = loaded ? cables - 3 : 0; spare >= 0;) {
    Matrix6d gram;
    gram.noalias() = by_turn * by_turn.transpose();
    for (Eigen::Index i = 0; i < cables; ++i)
      if (held_[static_cast<std::size_t>(i)] == 0)
        gram.noalias() += cables_.structure.col(i) * cables_.structure.col(i).transpose();
    multiplier = gram.ldlt().solve(wanted);
    tension_ = at.tension;
    bool more = false;
    for (Eigen::Index i = 0; i < cables; ++i) {
      char& held = held_[static_cast<std::size_t>(i)];
      if (held == 0) tension_[i] += cables_.structure.col(i).dot(multiplier);
      const double bound = std::clamp(tension_[i], robot_.cable.tension_min, robot_.cable.tension_max);
      if (held != 0) {
        tension_[i] = held < 0 ? robot_.cable.tension_min : robot_.cable.tension_max;
      } else if (loaded && bound != tension_[i] && spare > 0) {
        held = tension_[i] < bound ? -1 : 1;
        wanted.noalias() -= (bound - at.tension[i]) * cables_.structure.col(i);
        tension_[i] = bound;
        more = true;
        --spare;
      }
    }
    if (!more) break;
  }
  Eigen::Vector3d turn = kTurnScale * (by_turn.transpose() * multiplier);
  if (!loaded) {
    euler_ = at.euler + EulerRateMatrix(at.euler).inverse() * turn;
    return;
  }

  const Eigen::Vector3d step = turn - shift.turn_W;
  const double size = step.norm();
  if (size > kLargestStep) turn = shift.turn_W + kLargestStep / size * step;
  if (turn.norm() > kLargestTurn) turn *= kLargestTurn / turn.norm();
  shift.turn_W = turn;
  shift.tension = tension_ - at.tension;
  R_WB_ = RotationBy(turn) * RotationFromEuler(at.euler);
  euler_ = EulerFromRotation(R_WB_);
  for (int i = 0; i < 3; ++i) {
    constexpr double kRound = 2 * std::numbers::pi;
    euler_[i] += kRound * std::round((at.euler[i] - euler_[i]) / kRound);
  }
}

}  // namespace tenon
