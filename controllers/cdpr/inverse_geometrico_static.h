#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/plants/model/cdpr_description.h>

#include <Eigen/Core>

#include <optional>

namespace tenon {

/// A static equilibrium of the platform.
struct StaticEquilibrium {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();      ///< CoM [m]
  Eigen::Vector3d euler = Eigen::Vector3d::Zero();     ///< ZYX (roll, pitch, yaw), see euler.h [rad]
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();  ///< the same attitude
  CableVector tension;                                 ///< [N]
  CableVector length;                                  ///< attachment to anchor, under tension [m]
  double stiffness_min = 0;                            ///< see CalcLockedStiffness() [N/m]
};

struct StaticsOptions {
  /// Prescribed ZYX angles [rad], for six cables or more. If empty, the attitude is free.
  std::optional<Eigen::Vector3d> attitude = {};
  /// With a prescribed attitude: the tensions are those nearest to this value [N]; 0 gives the least
  /// tensions, the middle of the bounds those farthest from both bounds.
  double tension_aim = 0;
  /// Warm start: a neighbouring equilibrium whose branch is followed instead of searching over attitudes.
  std::optional<StaticEquilibrium> warm_start = {};
};

/// The attitude and the tensions that hold the CoM of the platform at a point.
///
/// They solve (Morlando 2023, eqs. (3.19)-(3.23))
///
///     W(p, Theta) u + [0 0 -m 9.81 0 0]^T = 0,     tension_min <= u <= tension_max
///
/// Four cables leave 3 + 4 unknowns for six equations, five leave 8: the equilibria at a point form a family
/// of one or two parameters (the matrix H of (3.22) is 3 x n and has no inverse; how hard the cables pull
/// against each other is free). The member of this family is returned that
///   - has its tensions within the bounds,
///   - is stable: CalcLockedStiffness() > 0,
///   - is a minimum of |u| among its neighbours, and of several such minima the least one.
/// If |u| is least at the limit of stability, there is no such member and the point is refused.
///
/// The search runs NLopt's SLSQP, with analytic gradients, from a fixed grid of attitudes within 35 deg of
/// Theta = 0, and rejects attitudes beyond 80 deg, where cables cross. Newton's method on the optimality
/// conditions, with the tensions at a bound fixed, refines the result until W u + g = 0 to rounding. The
/// search is deterministic. With a warm start it runs only if Newton's method fails.
///
/// With a prescribed attitude only (3.23) is left, see tension_distribution.h.
///
/// @throws ParameterError naming the robot, the point and the reason: above the anchors, no equilibrium, only
/// unstable ones, a cable out of its bounds (which one and by how much), or a robot that makes no sense.
StaticEquilibrium SolveInverseGeometricoStatic(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                               const StaticsOptions& options = {});

}  // namespace tenon
