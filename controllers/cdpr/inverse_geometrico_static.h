#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/plants/model/cdpr_description.h>

#include <Eigen/Core>

#include <optional>

namespace tenon {

/// A platform at rest: where, how, and with which cables.
struct StaticEquilibrium {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();      ///< CoM [m]
  Eigen::Vector3d euler = Eigen::Vector3d::Zero();     ///< ZYX (roll, pitch, yaw), see euler.h [rad]
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();  ///< the same attitude
  CableVector tension;                                 ///< [N]
  CableVector length;                                  ///< attachment to anchor, under tension [m]
  double stiffness_min = 0;                            ///< see CalcLockedStiffness() [N/m]
};

struct StaticsOptions {
  /// ZYX angles [rad] that the platform is to have; needs six cables or more. Free if empty.
  std::optional<Eigen::Vector3d> attitude = {};
  /// With an attitude: the tensions are those nearest to this one [N], 0 for the least ones. The middle of
  /// the bounds stays farthest away from both.
  double tension_aim = 0;
  /// A neighbouring equilibrium; its branch is followed as far as it goes, instead of a search over
  /// attitudes.
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
/// against each other is free). Of this family, the member is returned that
///   - has its tensions within the bounds,
///   - is stable: CalcLockedStiffness() > 0,
///   - is a minimum of |u| among its neighbours, and of several such minima the least one.
/// If |u| is least where the platform is about to tip over there is no such member and the point is refused.
///
/// The search runs NLopt's SLSQP, with analytic gradients, from a fixed grid of attitudes within 35 deg of
/// Theta = 0, and takes nothing beyond 80 deg, where cables cross. What it finds is polished by Newton's
/// method on the optimality conditions, with the tensions at a bound held there, until W u + g = 0 to
/// rounding. It is deterministic. With a warm start Newton's method alone runs, and the search only if that
/// fails.
///
/// With a prescribed attitude only (3.23) is left, see tension_distribution.h.
///
/// @throws ParameterError naming the robot, the point and the reason: above the anchors, no equilibrium, only
/// unstable ones, a cable out of its bounds (which one and by how much), or a robot that makes no sense.
StaticEquilibrium SolveInverseGeometricoStatic(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                               const StaticsOptions& options = {});

}  // namespace tenon
