#pragma once

#include <Eigen/Core>

#include <vector>

namespace tenon {

/// Wrenches that the cables must be able to exert on the platform: a box with the centre `centre` and the
/// half widths `half_width`. Six rows, force [N] before torque [N m] about the CoM in W; three for a point
/// mass, two in a plane.
struct WrenchBox {
  Eigen::VectorXd centre;
  Eigen::VectorXd half_width;
};

/// Margins of the required wrenches to the limits of the cables; negative if a wrench is beyond them.
struct WrenchMargins {
  /// Largest tightening of both tension bounds for which all required wrenches remain feasible [N].
  double tension = 0;
  /// Capacity margin: the largest wrench that can be added in any direction,
  /// sqrt(|force|^2 + |torque / lever|^2) [N]. If the pose is not feasible, minus the largest distance of a
  /// required wrench beyond its facet.
  double capacity = 0;
  int facet = 0;  ///< index of the facet that limits the tension margin

  bool feasible() const { return tension >= 0; }
};

/// Decides whether all wrenches of a required set are feasible within tension bounds, and computes the
/// margins.
///
/// The wrenches that tensions lo <= u <= hi produce, Z = {W u}, form a zonotope: a convex polytope of which
/// each facet is normal to d - 1 independent columns of W, d its rows. So Z is the intersection of
/// half-spaces c . w <= h(c), one pair of them for each choice of columns, with the support function
///
///     h(c) = mid sum_i c.w_i + half sum_i |c.w_i|,      mid, half = (hi + lo) / 2, (hi - lo) / 2
///
/// This is the hyperplane shifting method (Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010;
/// Gouttefarde, Krut, Advances in Robot Kinematics, 2010). With r(c) = c . centre + sum_k half_width_k |c_k|
/// the support function of the required wrenches, they are all produced if h(c) >= r(c) for each c, and the
/// margins are the minima over all facets of
///
///     tension:  (h(c) - r(c)) / sum_i |c.w_i|         capacity:  (h(c) - r(c)) / |c|
///
/// The first follows from h once more: bounds that are tighter by m lower it by m sum_i |c.w_i|.
///
/// SetStructure() finds all normals by Gaussian elimination of [W | 1], one chosen column after the other,
/// down to three rows. Choices with a common beginning share their steps. In the space of these rows the
/// normal to two more columns is their cross product n, and n times the rows is [c.w_1 ... c.w_n | c]:
/// several choices side by side. Dependent columns bound no facet; if rounding makes a normal of them, it
/// does no harm, since h(c) >= r(c) is necessary for any c. The cost grows with the binomial coefficient n
/// over d - 1: 56 choices for 8 cables in space, 792 for 12. Allocates only in the constructor.
class WrenchFeasibility {
 public:
  /// @throws ParameterError unless 2 <= rows <= cables.
  WrenchFeasibility(int rows, int num_cables);

  /// The structure matrix, see CableKinematics: a column for each cable, the wrench of a unit tension. Rows
  /// of torques are divided by a lever [m] before, and so are those of the required wrenches, so that all are
  /// forces: the size of the platform is a good one. The tension margin does not depend on it.
  /// @throws ParameterError if the matrix has another size.
  void SetStructure(const Eigen::Ref<const Eigen::MatrixXd>& structure);

  /// Tensions are within [tension_min, tension_max] [N]; both finite.
  WrenchMargins Margins(const WrenchBox& required, double tension_min, double tension_max) const;

  int num_facets() const { return num_facets_; }  ///< number of pairs of facets, n over d - 1
  /// Normal of a facet, not of unit length; 0 if its cables are dependent. The opposite facet has the
  /// opposite normal.
  auto normal(int facet) const { return normals_.row(facet).transpose(); }
  /// Indices of the rows - 1 cables whose columns are parallel to the facet.
  auto cables(int facet) const { return cables_.col(facet); }

 private:
  void Eliminate(int level, int first);
  int Cross(const double* rows, int columns, int first);
  void AddFacets(const double* rows, int columns, int count);
  void SkipFacets(int count);

  int rows_, num_cables_, width_;  // width: columns of [W | 1], filled up
  // Level k: d - k rows of that width, without the columns that are eliminated.
  std::vector<std::vector<double>> levels_;
  double smallest_pivot_ = 0;
  Eigen::MatrixXi cables_;  // a column for each facet
  Eigen::MatrixX3d cross_;  // n, a row for each of the facets that are computed together
  int num_facets_ = 0, facets_done_ = 0;
  // With a row for each facet, and some more.
  Eigen::MatrixXd normals_;             // c
  Eigen::VectorXd sum_, absolute_sum_;  // of c.w_i over the cables
  Eigen::VectorXd square_;              // |c|^2
};

}  // namespace tenon
