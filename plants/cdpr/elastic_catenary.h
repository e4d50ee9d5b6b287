#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// An elastic cable that hangs at rest between two points, by its weight and its strain (Irvine, Cable
/// Structures, MIT Press 1981, section 1.3).
///
/// It lies in a vertical plane with z up, starts at the origin and ends at (x, z), x >= 0. s is the
/// unstrained length along the cable, L the total one, and w the weight per unstrained length. The tension T
/// has the constant horizontal part H and the vertical part V(s) = V_m + w (s - L/2). By Hooke's law each
/// piece ds is stretched to (1 + T/EA) ds along the tangent, so
///
///     (x, z) = integral of (1/EA + 1/T) (H, V) ds,
///     x = H L/EA + (H/w) (asinh(V_e/H) - asinh(V_s/H)),     V_s, V_e = V_m -+ w L/2
///     z = V_m L/EA + (T_e - T_s)/w.
///
/// The right-hand side is the gradient of the convex function integral of (T^2/(2 EA) + T) ds of (H, V_m).
/// Therefore every pair of end points has exactly one solution, taut or slack. Newton's method converges to
/// it from any start if it does not step past the minimum along its direction. The differences are evaluated
/// without loss of precision for small weights; the limit of zero weight is the straight cable.
struct ElasticCatenary {
  // Properties.
  double rest_length = 0;      ///< L [m]
  double weight = 0;           ///< w [N/m]
  double axial_stiffness = 0;  ///< EA [N]

  // Solution.
  double horizontal = 0;      ///< H [N]
  double vertical = 0;        ///< V_m, vertical part in the middle [N]
  double tension_start = 0;   ///< T_s [N]
  double tension_end = 0;     ///< T_e [N]
  double length = 0;          ///< strained length along the cable [m]
  double elastic_energy = 0;  ///< [J]
  double potential_energy =
      0;  ///< potential energy of the weight relative to the middle between the ends [J]
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> stiffness =
      Eigen::Matrix2d::Zero();  ///< d(H, V_m) / d(x, z), symmetric, positive definite [N/m]
  int iterations = 0;

  double vertical_start() const { return vertical - weight * rest_length / 2; }
  double vertical_end() const { return vertical + weight * rest_length / 2; }
  /// Position of the cable at s, from its start [m].
  Vec<2> PointAt(double s) const;
};

/// Computes the shape of a cable from the origin to (x, z). Length, weight and stiffness must be positive.
/// The search may start at the solution `near`. Does not allocate.
/// @throws RunError if an argument is not positive, or if Newton's method fails (no such case is known).
ElasticCatenary HangCatenary(double rest_length, double weight, double axial_stiffness, double x, double z,
                             const ElasticCatenary* near = nullptr);

}  // namespace tenon
