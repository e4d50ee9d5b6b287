#include <tenon/controllers/cdpr/balanced_reference.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <Eigen/Geometry>

#include <algorithm>

namespace tenon {
namespace {

// Turn [rad] that costs as much as 1 N. It is smaller with a broken cable: the others can often hold the
// attitude, with very different tensions.
constexpr double kTurnScale = 1e-3, kTurnScaleBroken = 1e-5;
constexpr double kLargestStep = 0.1;        // largest change of the turn in a call [rad]
constexpr double kLargestTurn = 1.2;        // saturation of the turn; cables cross at larger turns [rad]
constexpr double kLargestTurnBroken = 0.5;  // saturation of the turn with a broken cable [rad]
constexpr double kExcess = 1;               // tolerated excess over a bound [N]

Eigen::Matrix3d RotationBy(const Eigen::Vector3d& turn) {
  return RotationFromQuaternion(QuaternionFromRotationVector(turn));
}

}  // namespace

void BalancedReference::Calc(const CdprReference& at, const LoadEstimate& load, const CableVector& broken,
                             ReferenceShift& shift, double time) {
  const Eigen::Index num_broken = (broken.array() != 0).count();
  const bool loaded = load.any() || num_broken > 0;
  const double turn_scale = num_broken > 0 ? kTurnScaleBroken : kTurnScale;
  if (!loaded || shift.tension.size() != at.tension.size()) {
    shift.turn_W.setZero();
    shift.tension.setZero(at.tension.size());
  }
  tension_ = at.tension + shift.tension;
  const Eigen::Matrix3d R_reference = RotationFromEuler(at.euler);
  R_WB_ = R_reference;
  if (loaded) R_WB_ = RotationBy(shift.turn_W) * R_reference;
  CalcCableKinematics(robot_, at.position, R_WB_, &cables_, anchors_, time);

  // Newton's step with the smallest change, computed by the multiplier of the equation:
  // change = J^T multiplier, J J^T multiplier = J change_before - residual.
  Eigen::Matrix<double, 6, 3> by_turn = turn_scale * CalcWrenchByTurn(cables_, tension_);
  Matrix6d passive_jacobian;
  const Vector6d passive = PassiveWrench(robot_, at.position, R_WB_, &passive_jacobian);
  if (!robot_.springs.empty()) by_turn += turn_scale * passive_jacobian.rightCols<3>();
  Vector6d wanted = Vector6d::Zero();
  wanted.head<3>() = robot_.mass * at.acceleration;
  if (loaded) {
    const Eigen::Vector3d arm_W = R_WB_ * load.payload.p_B;
    const Eigen::Vector3d carried =
        load.payload.mass * (GravityWrench(robot_).head<3>() / robot_.mass - at.acceleration);
    // The derivative of arm x carried with respect to a turn t is (t x arm) x carried.
    by_turn.bottomRows<3>() +=
        turn_scale * (arm_W * carried.transpose() - carried.dot(arm_W) * Eigen::Matrix3d::Identity());
    wanted -= passive;
    wanted.head<3>() -= carried + load.rest.force_W;
    wanted.tail<3>() -= arm_W.cross(carried) + load.rest.torque_W;
    wanted.noalias() += by_turn * (shift.turn_W / turn_scale);
    wanted.noalias() -= cables_.structure * at.tension;
  }
  // The equations of motions that the cables do not govern become 0 = multiplier.
  Vector6d solved = Vector6d::Zero();
  for (const int motion : motions_) solved[motion] = 1;
  if (motions_.size() < 6) {
    by_turn = solved.asDiagonal() * by_turn * solved.tail<3>().asDiagonal();
    wanted = solved.asDiagonal() * wanted;
  }
  // Fixes tensions at the bounds that they exceed, one at a time and the largest excess first, as long as
  // enough cables remain free.
  Vector6d multiplier;
  const Eigen::Index cables = at.tension.size();
  held_.assign(static_cast<std::size_t>(cables), 0);
  for (Eigen::Index i = 0; i < broken.size(); ++i) {
    if (broken[i] == 0) continue;
    held_[i] = 1;
    tension_[i] = 0;
    wanted.noalias() += at.tension[i] * cables_.structure.col(i);
  }
  double excess = 0;  // largest excess of a tension over its bound [N]
  for (Eigen::Index spare = loaded ? std::max<Eigen::Index>(cables - 3 - num_broken, 0) : 0;; --spare) {
    Matrix6d gram;
    gram.noalias() = by_turn * by_turn.transpose();
    for (Eigen::Index i = 0; i < cables; ++i)
      if (held_[i] == 0) gram.noalias() += cables_.structure.col(i) * cables_.structure.col(i).transpose();
    gram.diagonal() += Vector6d::Ones() - solved;
    multiplier = internal::SolveLdlt<6>(gram, wanted);
    excess = 0;
    Eigen::Index worst = 0;
    for (Eigen::Index i = 0; i < cables; ++i) {
      if (held_[i] != 0) continue;
      tension_[i] = at.tension[i] + cables_.structure.col(i).dot(multiplier);
      const double beyond =
          std::max(robot_.tension_min(i) - tension_[i], tension_[i] - robot_.tension_max(i));
      if (beyond > excess) {
        excess = beyond;
        worst = i;
      }
    }
    if (excess == 0 || spare == 0) break;
    const double bound = std::clamp(tension_[worst], robot_.tension_min(worst), robot_.tension_max(worst));
    held_[worst] = 1;
    wanted.noalias() -= (bound - at.tension[worst]) * cables_.structure.col(worst);
    tension_[worst] = bound;
  }
  Eigen::Vector3d turn = turn_scale * (by_turn.transpose() * multiplier);
  if (!loaded) {
    shift.held = true;
    euler_ = at.euler + internal::Inverse<3>(EulerRateMatrix(at.euler)) * turn;
    return;
  }

  const Eigen::Vector3d step = turn - shift.turn_W;
  const double size = step.norm();
  if (size > kLargestStep) turn = shift.turn_W + kLargestStep / size * step;
  const double largest_turn = num_broken > 0 ? kLargestTurnBroken : kLargestTurn;
  if (turn.norm() > largest_turn) {
    turn *= largest_turn / turn.norm();
    excess = std::numeric_limits<double>::infinity();
  }
  shift.held = num_broken == 0 || excess <= kExcess;
  shift.turn_W = turn;
  shift.tension = tension_ - at.tension;
  R_WB_ = RotationBy(turn) * R_reference;
  euler_ = EulerNear(EulerFromRotation(R_WB_), at.euler);
}

}  // namespace tenon
