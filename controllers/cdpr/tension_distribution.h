#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>

#include <string>

namespace tenon {

/// Tensions, or why there are none.
struct TensionDistribution {
  bool feasible = false;
  CableVector tension;         ///< least norm within the bounds; without the bounds if not feasible [N]
  double residual_force = 0;   ///< force that no tensions produce, |b - W u| in its first three rows [N]
  double residual_torque = 0;  ///< the same for the last three rows [N m]
  std::string reason;          ///< empty if feasible; only a refusal allocates
};

/// Cable tensions of least norm for a wrench at one pose (Morlando 2023, eqs. (3.23) and (3.24)):
///
///     min |u|^2   subject to   W u = b,   tension_min <= u <= tension_max
///
/// W is CableKinematics::structure and b the wrench [N, N m] that the cables are to put on the platform,
/// about the CoM and in W, force first; at rest b = -GravityWrench(robot), which is eq. (3.19). The sign of m
/// g printed there is the other one.
///
/// The equation fixes u up to the null space of W, u = u0 + N z with u0 normal to N, and what remains is a
/// least distance problem, min |z|^2 with the bounds as inequalities. It is solved exactly in finitely many
/// steps as a non-negative least squares problem (Lawson and Hanson, Solving Least Squares Problems, 1974,
/// ch. 23). Nothing is allocated as long as the problem is feasible.
///
/// With fewer than six cables W u = b has no solution but at the attitudes of equilibrium, see
/// inverse_geometrico_static.h; elsewhere the residual is what is refused.
///
/// `tolerance` is the largest |b - W u| relative to the largest force and the largest torque in the balance.
/// Either bound may be infinite. Refuses, and never throws.
TensionDistribution DistributeTension(const CableMatrix6& structure, const Vector6d& wrench,
                                      double tension_min, double tension_max, double tolerance = 1e-8);

}  // namespace tenon
