#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/optimization/dual_active_set.h>

#include <Eigen/QR>

namespace tenon {

/// A distribution of tensions, or the reason why there is none.
struct TensionDistribution {
  bool feasible = false;
  CableVector tension;  ///< least-norm tensions within the bounds, or without bounds if not feasible [N]
  double residual_force = 0;   ///< force that the tensions lack, |b - W u| in the first three rows [N]
  double residual_torque = 0;  ///< torque that the tensions lack, |b - W u| in the last three rows [N m]
  std::string reason;          ///< reason of the infeasibility; empty if feasible
};

/// Cable tensions of least norm for a wrench at one pose (Morlando 2023, eqs. (3.23) and (3.24)):
///
///     min |u|^2   subject to   W u = b,   tension_min <= u <= tension_max
///
/// W is CableKinematics::structure and b the wrench [N, N m] of the cables on the platform, about the CoM and
/// in W, force first; at rest b = -GravityWrench(robot), which is eq. (3.19) with the sign of m g corrected.
///
/// The equation determines u up to the null space N of W: u = u0 + N z with u0 normal to N. This leaves a
/// least-distance problem, min |z|^2 with the bounds as inequalities, which DualActiveSet solves.
///
/// With fewer than six cables, W u = b has a solution only at the attitudes of equilibrium, see
/// inverse_geometrico_static.h. At other attitudes the problem is infeasible because of its residual.
///
/// Solve() does not allocate as long as the problem is feasible. Copies are independent.
class TensionDistributor {
 public:
  explicit TensionDistributor(int num_cables);

  /// `tolerance` is the largest |b - W u| relative to the largest force and the largest torque in the
  /// balance. Bounds may be infinite. The result is valid until the next call.
  /// @throws ParameterError if the number of columns of W is not the number of cables.
  const TensionDistribution& Solve(const CableMatrix6& structure, const Vector6d& wrench,
                                   const CableVector& tension_min, const CableVector& tension_max,
                                   double tolerance = 1e-8);

 private:
  bool MoveIntoBounds(int rank, const CableVector& lower, const CableVector& upper);

  Eigen::ColPivHouseholderQR<Eigen::MatrixXd>
      qr_;  // decomposition of W^T with torques divided by the longest lever
  Eigen::MatrixXd transposed_, Q_;
  Eigen::VectorXd u_, work_;  // u_ is the solution without bounds
  // Problem of MoveIntoBounds.
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_, bounds_;
  ConstraintMatrix rows_;
  DualActiveSet solver_;
  TensionDistribution result_;
};

/// Solves one problem for the tensions with the smallest distance |u - aim| [N], instead of the smallest
/// norm. The result changes continuously with structure and wrench.
TensionDistribution DistributeTension(const CableMatrix6& structure, const Vector6d& wrench,
                                      const CableVector& tension_min, const CableVector& tension_max,
                                      double aim = 0, double tolerance = 1e-8);

}  // namespace tenon
