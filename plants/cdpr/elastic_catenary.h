#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <Eigen/Core>

namespace tenon {

/// An elastic cable that hangs at rest between two points, by its weight and its strain (Irvine, Cable
/// Structures, MIT Press 1981, section 1.3).
///
/// In a vertical plane with z up, it starts at the origin and ends at (x, z), x >= 0. s is the length along
/// it without strain, L in all; w its weight per such length. The tension T has the horizontal part H all
/// along and the vertical part V(s) = V_m + w (s - L/2), by which it pulls forward. Because Hooke's law
/// stretches each piece to (1 + T/EA) ds along its tangent,
///
///     (x, z) = integral of (1/EA + 1/T) (H, V) ds,
///     x = H L/EA + (H/w) (asinh(V_e/H) - asinh(V_s/H)),     V_s, V_e = V_m -+ w L/2
///     z = V_m L/EA + (T_e - T_s)/w.
///
/// The right-hand side is the gradient of the convex function integral of (T^2/(2 EA) + T) ds of (H, V_m).
/// There is thus one solution for every place of the ends, taut or slack, and Newton's method finds it from
/// any start if it does not step past the minimum along its direction. The differences are written such
/// that a weight that tends to 0 costs no digit: the limit is the straight cable.
struct ElasticCatenary {
  // Properties.
  double rest_length = 0;      ///< L [m]
  double weight = 0;           ///< w [N/m]
  double axial_stiffness = 0;  ///< EA [N]

  // Solution.
  double horizontal = 0;        ///< H [N]
  double vertical = 0;          ///< V_m, in the middle [N]
  double tension_start = 0;     ///< T_s [N]
  double tension_end = 0;       ///< T_e [N]
  double length = 0;            ///< along the cable, under strain [m]
  double elastic_energy = 0;    ///< [J]
  double potential_energy = 0;  ///< energy of its weight, above the middle between its ends [J]
  Eigen::Matrix2d stiffness =
      Eigen::Matrix2d::Zero();  ///< d(H, V_m) / d(x, z), symmetric, positive definite [N/m]
  int iterations = 0;

  double vertical_start() const { return vertical - weight * rest_length / 2; }
  double vertical_end() const { return vertical + weight * rest_length / 2; }
  /// Position of the piece at s, from the start [m].
  Vec<2> PointAt(double s) const;
};

/// Hangs a cable from the origin to (x, z); length, weight and stiffness must be positive. The search may
/// start at a `near` solution. Does not allocate.
/// @throws RunError if an argument is not positive, or if Newton's method fails (no such case is known).
ElasticCatenary HangCatenary(double rest_length, double weight, double axial_stiffness, double x, double z,
                             const ElasticCatenary* near = nullptr);

}  // namespace tenon
