#pragma once

#include <tenon/controllers/legged/planning/com_planner.h>

namespace tenon {

/// The nonlinear program of TrajectoryPlanner, for NLopt: the motion of the CoM c of a walking robot, the
/// loads w_i of its feet and their places p_i (after Winkler et al., Fast trajectory optimization for legged
/// robots using vertex-based ZMP constraints, RA-L 2017). Unknown are the acceleration a at each knot, linear
/// in time in between, w_i >= least_load of the feet that carry at the knot, and the horizontal places of
/// chosen footholds, in boxes. In lengths of the CoM's height h, times of sqrt(h / g), and at each knot,
///
///     a + e_z = sum_i w_i (c - p_i)           (dynamics with constant angular momentum)
///     a_x^2 + a_y^2 <= mu^2 (1 + a_z)^2       (friction cone)
///     |c + hip_i - p_i|^2 <= reach_i^2        (lengths of the legs)
///
/// The forces f_i = w_i / (sum w) m (a + e_z) move the CoM so, in the cone, without a moment about it.
///
/// The cost is the integral of the weighted squares, see TrajectoryProperties. The vector z that NLopt sees
/// has the unknowns in coordinates in which it is |z - best|^2 / 2, as SLSQP assumes at its start.
class TrajectoryProblem {
 public:
  struct Foothold {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< the wanted one if it is chosen
    Eigen::Vector2d lower = Eigen::Vector2d::Zero(), upper = Eigen::Vector2d::Zero();
    bool chosen = false;
  };
  struct Knot {
    double time = 0;
    Eigen::Vector3d path;                         ///< wanted place of the CoM
    std::array<int, kNumLegs> foot;               ///< index of each leg's foothold
    std::array<bool, kNumLegs> reaches, carries;  ///< it stands before or after the knot; before and after
    std::array<Eigen::Vector3d, kNumLegs> hip;    ///< from the CoM
  };
  std::vector<Knot> knots;
  std::vector<Foothold> feet;
  Eigen::Vector3d start, velocity, end_velocity;  ///< of the start, and wanted at the end
  std::array<double, kNumLegs> reach{};
  double friction = 0.6;
  TrajectoryProperties properties;

  void Prepare();                    ///< sets the members below from those above
  std::vector<double> lower, upper;  ///< bounds of z
  int num_knots() const { return static_cast<int>(knots.size()); }
  int num_equalities() const { return 3 * num_knots(); }
  int num_inequalities() const { return (1 + kNumLegs) * num_knots(); }
  /// Indices in u: positions and accelerations of the CoM, loads, and places of the feet.
  int C(int knot, int axis) const { return axis * num_knots() + knot; }
  int A(int knot, int axis) const { return (3 + axis) * num_knots() + knot; }
  int W(int knot, int leg) const { return (6 + leg) * num_knots() + knot; }
  int P(int foot, int axis) const { return (6 + kNumLegs) * num_knots() + 3 * foot + axis; }
  /// u at z; z = 0 stands for no acceleration, equal loads and the wanted places.
  const Eigen::VectorXd& U(const double* z);
  void Guess(const double* u, double* z) const;  ///< z of u but for its positions, within the bounds

  double Cost(const double* z, double* gradient) const;
  /// Values that must be zero, and at most zero. Jacobians are written by rows, unless they are null.
  void Equalities(const double* z, double* values, double* jacobian);
  void Inequalities(const double* z, double* values, double* jacobian);
  /// Improves z by NLopt's SLSQP, until the cost changes by less than its part `accuracy`. Returns which
  /// constraint is violated by more than `accuracy`, if any.
  std::string Solve(int max_evaluations, double accuracy, double* z);
  int evaluations = 0;  ///< of the last solve

 private:
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_z_;
  Eigen::VectorXd u_, constant_, best_, values_;  // u = constant + by_z z
  Eigen::MatrixXd factor_[2];  // L of the Hessian L L' by accelerations, horizontal and vertical
  std::vector<int> at_;        // index in u of each other unknown
  struct {
    Eigen::MatrixXd position, speed, weighted;  // by the accelerations; weighted by `duration`
    Eigen::VectorXd duration;                   // that a knot stands for
    Eigen::RowVectorXd divergent;
  } memory_;
};

}  // namespace tenon
