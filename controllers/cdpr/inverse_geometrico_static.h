#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>

namespace tenon {

/// A static equilibrium of the platform.
struct StaticEquilibrium {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();      ///< CoM [m]
  Eigen::Vector3d euler = Eigen::Vector3d::Zero();     ///< ZYX (roll, pitch, yaw), see euler.h [rad]
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();  ///< attitude as a rotation matrix
  CableVector tension;                                 ///< [N]
  CableVector length;        ///< lengths from attachment to anchor, under tension [m]
  double stiffness_min = 0;  ///< see CalcLockedStiffness() [N/m]
};

struct StaticsOptions {
  /// Prescribed ZYX angles [rad], for six cables or more. If empty, the attitude is free.
  std::optional<Eigen::Vector3d> attitude = {};
  /// Desired tension [N] with a prescribed attitude: among the tensions that hold the platform, the nearest
  /// to this value are chosen. With 0 they are as small as possible, with the middle of the bounds as far as
  /// possible from both bounds.
  double tension_aim = 0;
  /// Warm start: a neighbouring equilibrium whose branch is followed instead of searching over attitudes.
  std::optional<StaticEquilibrium> warm_start = {};
};

/// Returns the attitude and the tensions that hold the platform with its CoM at a point.
///
/// The result solves (Morlando 2023, eqs. (3.19)-(3.23))
///
///     W(p, Theta) u + [0 0 -m 9.81 0 0]^T + (wrench of the springs) = 0,     tension_min <= u <= tension_max
///
/// Four cables leave 3 + 4 unknowns for six equations, five leave 8: the equilibria at a point form a family
/// with one or two parameters. (The matrix H of (3.22) is 3 x n and has no inverse; the internal tension is
/// free.) The result is the member of this family that
///  - has its tensions within the bounds,
///  - is stable: CalcLockedStiffness() > 0,
///  - is a local minimum of |u|, and the smallest of several such minima.
/// If |u| is smallest at the limit of stability, there is no such member and the point is refused.
///
/// The search runs NLopt's SLSQP, with analytic gradients, from a fixed grid of attitudes within 35 deg of
/// Theta = 0, and rejects attitudes beyond 80 deg, where cables cross. Newton's method on the optimality
/// conditions, with the tensions at a bound fixed, refines the result until W u + g = 0 to rounding. The
/// search is deterministic. With a warm start it runs only if Newton's method fails.
///
/// With a prescribed attitude only (3.23) remains to be solved, see tension_distribution.h.
///
/// @throws ParameterError with the robot, the point and the reason: a point above the anchors, no
/// equilibrium, only unstable equilibria, a tension beyond its bounds (with the cable and the excess), or an
/// invalid robot.
StaticEquilibrium SolveInverseGeometricoStatic(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                               const StaticsOptions& options = {});

}  // namespace tenon
