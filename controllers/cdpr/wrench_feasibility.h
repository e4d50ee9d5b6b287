#pragma once

#include <tenon/plants/signals/cable_vector.h>

namespace tenon {

/// Wrenches that the cables must be able to exert on the platform, as a box with the centre `centre` and the
/// half edges `half_width`. There are six rows, force [N] before torque [N m] about the CoM in W; for a point
/// mass three, or two in a plane.
struct WrenchBox {
  Eigen::VectorXd centre;
  Eigen::VectorXd half_width;
};

/// Margins of the required wrenches to the limits of the cables; negative if a wrench is beyond them.
struct WrenchMargins {
  /// Largest tightening of both tension bounds for which all required wrenches remain feasible [N].
  double tension = 0;
  /// Capacity margin: the magnitude sqrt(|force|^2 + |torque / lever|^2) of the largest wrench that can be
  /// added in every direction [N]. If the pose is not feasible, it is negative: the distance of the farthest
  /// required wrench from its facet.
  double capacity = 0;
  int facet = 0;  ///< index of the facet that limits the tension margin

  bool feasible() const { return tension >= 0; }
};

/// Decides whether all wrenches of a required set are feasible within tension bounds, and computes the
/// margins.
///
/// The wrenches that tensions lo <= u <= hi can produce, Z = {W u}, form a zonotope: a convex polytope of
/// which each facet is normal to d - 1 independent columns of W with d rows. Z is therefore the intersection
/// of half-spaces c . w <= h(c), one pair for each choice of columns, with the support function
///
///     h(c) = sum_i mid_i c.w_i + half_i |c.w_i|,      mid, half = (hi + lo) / 2, (hi - lo) / 2
///
/// This is the hyperplane shifting method (Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010;
/// Gouttefarde, Krut, Advances in Robot Kinematics, 2010). The support function of the required wrenches is
/// r(c) = c . centre + sum_k half_width_k |c_k|. All required wrenches are feasible if h(c) >= r(c) for each
/// c, and the margins are the minima over all facets of
///
///     tension:  (h(c) - r(c)) / sum_i |c.w_i|         capacity:  (h(c) - r(c)) / |c|
///
/// The tension margin follows from h: tightening all bounds by m decreases h by m sum_i |c.w_i|. It is at
/// most the least half_i, at which the bounds of a cable meet.
///
/// SetStructure() finds all normals by Gaussian elimination of [W | 1], one chosen column after the other,
/// until three rows remain. Choices that begin with the same columns share these steps. In the space of the
/// three rows, the normal to two more columns is their cross product n, and n times the rows is [c.w_1 ...
/// c.w_n | c]; several choices are computed side by side. Dependent columns form no facet; if rounding yields
/// a normal for them it does no harm, since h(c) >= r(c) is necessary for any c. The cost grows with the
/// binomial coefficient n over d - 1: 56 choices for 8 cables in space, 792 for 12. Allocates only in the
/// constructor.
class WrenchFeasibility {
 public:
  /// @throws ParameterError unless 2 <= rows <= cables, or if bounds [N] are not finite and increasing.
  WrenchFeasibility(int rows, const CableVector& tension_min, const CableVector& tension_max);

  /// Sets the structure matrix, see CableKinematics: one column for each cable, the wrench of a unit tension.
  /// Rows of torques, and those of the required wrenches, must be divided by a lever [m], such as the size of
  /// the platform, so that all rows are forces. The tension margin does not depend on the lever.
  /// @throws ParameterError if the matrix has another size.
  void SetStructure(const Eigen::Ref<const Eigen::MatrixXd>& structure);

  /// Margins to the limits of tensions from lo to lo + share (hi - lo).
  WrenchMargins Margins(const WrenchBox& required, double share = 1) const;

  int num_facets() const { return num_facets_; }  ///< number of pairs of facets, n over d - 1
  /// Returns the normal of a facet, not of unit length, or 0 if its cables are dependent. The opposite facet
  /// has the opposite normal.
  auto normal(int facet) const { return normals_.row(facet).transpose(); }
  /// Returns the indices of the rows - 1 cables whose columns are parallel to the facet.
  auto cables(int facet) const { return cables_.col(facet); }

 private:
  void Eliminate(int level, int first);
  int Cross(const double* rows, int columns, int first);
  void AddFacets(const double* rows, int columns, int count);
  void SkipFacets(int count);

  int rows_, num_cables_, width_;             // width: number of columns of [W | 1], padded
  CableVector low_, half_;                    // lo and half of each cable [N]
  double most_ = 0;                           // the largest half [N]
  Eigen::VectorXd low_wrench_, half_wrench_;  // W lo and W half
  // Remaining d - k rows after k elimination steps, without the eliminated columns, and a row half_i / most.
  std::vector<std::vector<double>> levels_;
  double smallest_pivot_ = 0;
  Eigen::MatrixXi cables_;  // one column for each facet
  Eigen::MatrixX3d cross_;  // normals n, one row for each of the facets that are computed together
  int num_facets_ = 0, facets_done_ = 0;
  // Matrices with one row for each facet, padded.
  Eigen::MatrixXd normals_;                  // c
  Eigen::VectorXd absolute_sum_, half_sum_;  // sums over the cables of |c.w_i| and of half_i |c.w_i| / most
  Eigen::VectorXd square_;                   // |c|^2
};

}  // namespace tenon
