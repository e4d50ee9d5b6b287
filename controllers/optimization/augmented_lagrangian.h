#pragma once

#include <algorithm>

namespace tenon {

/// Augmented Lagrangian of a constraint c >= 0 (Nocedal and Wright 2006, section 17.4), for path constraints
/// (Morlando 2023, eq. (3.13)) in the stage cost of a problem for Slq. To the cost is added
///
///     psi(c) = (max(0, lambda - rho c)^2 - lambda^2) / (2 rho),   dpsi/dc = -max(0, lambda - rho c)
///
/// with the Gauss-Newton Hessian rho (dc/dx)(dc/dx)^T where dpsi/dc is not 0. After a solve, or one iteration
/// of it, -dpsi/dc is the next multiplier lambda; lambda converges to that of the constraint, and c to its
/// bound, at any penalty rho > 0, the faster the larger rho.
struct AugmentedLagrangian {
  double penalty = 1;  ///< rho

  double Cost(double c, double multiplier) const {
    const double next = Multiplier(c, multiplier);
    return (next * next - multiplier * multiplier) / (2 * penalty);
  }
  /// The next multiplier, -dpsi/dc.
  double Multiplier(double c, double multiplier) const { return std::max(0.0, multiplier - penalty * c); }
};

}  // namespace tenon
