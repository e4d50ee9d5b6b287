#pragma once

#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/controllers/cdpr/wrench_feasibility.h>

namespace tenon {

/// Verdict on a property of a set of poses.
enum class PoseVerdict {
  kHolds,      ///< it holds at each pose
  kFails,      ///< it fails at each pose
  kUndecided,  ///< it holds at some poses only, or the bounds are too wide to decide
};
constexpr auto EnumNames(PoseVerdict) {
  return std::array{Named{PoseVerdict::kHolds, "holds"}, Named{PoseVerdict::kFails, "fails"},
                    Named{PoseVerdict::kUndecided, "undecided"}};
}

/// A neighbourhood of a pose: all poses with the CoM within `distance` [m] of p_WB and with an attitude that
/// differs from R_WB by a rotation of at most `angle` [rad] about any axis.
struct PoseBall {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  double distance = 0;
  double angle = 0;
};

/// The wrenches that a platform needs [N, N m]: its weight and that of a load at its CoM, accelerations of
/// both up to `acceleration` along each axis, and external forces and torques up to `force` and `torque`
/// along each axis.
struct PlatformDemand {
  double load = 0;          ///< [kg]
  double acceleration = 0;  ///< [m/s^2]
  double force = 0;         ///< [N]
  double torque = 0;        ///< [N m]

  void Validate() const;  ///< throws ParameterError
};
WrenchBox RequiredWrenches(const CdprDescription& robot, const PlatformDemand& demand);

/// Wrench feasibility of a cable robot at a pose and over a set of poses: whether the cables can exert all
/// required wrenches, less that of the robot's springs, within their tension bounds. For robots with six or
/// more cables, or for a point mass (all attachments at the CoM) with three or more; in the plane of a planar
/// robot (see PlaneOf) three and two. Pulleys are treated as points.
///
/// The margin at one pose says nothing about neighbouring poses. Over() bounds the changes over the set. If
/// the CoM moves by rho and the platform turns by phi, attachment i moves by at most rho + 2 sin(phi/2)
/// |arm_i|. Its cable then turns by at most arcsin(move / length), and its column w_i of W, with torques
/// divided by a lever, changes by at most some d_i. To first order the column changes by its derivatives; the
/// remainder is at most r_i, a bound of the second derivatives.
///
/// **Proof of feasibility.** At the centre, tensions u produce a required wrench w, W u = w. At another pose,
/// W + D produces w with the tensions u + G y, where G = W^T (W W^T)^-1 is the pseudo-inverse and
/// (1 + D G) y = -D u. There is such a y if eps = sum_i d_i |G_i| < 1, and all tensions stay within their
/// bounds if for all cables i
///
///     |G_i| sum_j u_j d_j / (1 - eps) <= m_i,      or more sharply
///     |G_i J x| + |G_i| (sum_j u_j r_j + |D u| eps / (1 - eps)) <= m_i,      J x = D u to first order
///
/// with the distance m_i of u_i from its bounds.
///
/// The first condition is evaluated with the tension margin as m_i and with upper bounds of u: the best
/// of several bounds tighter than those of the cables and, if all cables pull upwards, a bound of their sum
/// by sum_j u_j (up . w_j) = up . w. The second condition is evaluated with one u for each required wrench:
/// small tensions away from the bounds at the middle of the box, see tension_distribution.h, and u + G (w -
/// middle) elsewhere.
///
/// **Proof of infeasibility.** A required wrench w is beyond a facet at the centre, c . w > h(c), and remains
/// so if each c . w_i increases by its largest change. The normal c is either constant, or it follows the
/// cables of its facet, so that their products c . w_i stay zero.
///
/// **Springs.** Their wrench at the centre moves the required ones. Over the set it changes by a spring whose
/// attachment moves by at most s by |dF| <= k s max(1, l0 / (l - s) - 1), and its torque by |arm| (|dF| + |F|
/// 2 sin(phi/2)): the first proof adds these to
/// the half widths, the second one subtracts them.
///
/// Apart from rounding, both are proofs, as in interval analysis (Gouttefarde, Daney, Merlet, IEEE Trans.
/// Robotics 27(1), 2011, doi:10.1109/TRO.2010.2090064). They become sharp as rho and phi tend to zero.
class PoseFeasibility {
 public:
  /// `required` has six rows. @throws ParameterError for too few cables and for an invalid robot.
  PoseFeasibility(const CdprDescription& robot, const WrenchBox& required);

  /// Returns the margins at a pose, or minus infinity if a cable has no length.
  WrenchMargins At(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  PoseVerdict Over(const PoseBall& poses);
  /// Returns whether no two cables are nearer than `diameter` [m] and no cable runs through the platform.
  PoseVerdict IsClearOver(const PoseBall& poses, double diameter);

  /// Results of the last call, at the centre:
  const WrenchMargins& margins() const { return margins_; }
  const CableClearance& clearance() const { return clearance_; }  ///< after IsClearOver()

 private:
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  bool turns() const { return rows_ > forces_; }
  bool Move(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  bool BoundChanges(const PoseBall& poses);
  void BoundSprings(const PoseBall& poses);
  void Differentiate(const PoseBall& poses);
  double OverBall(const Eigen::Matrix<double, 1, 6>& row) const;
  double ChangeAlong(const SmallVector& c, int cable) const;
  bool HoldsOver();
  bool HoldsByMargin(double gain) const;
  bool HoldsByTensions(const SmallMatrix& gram_inverse, double contraction);
  bool FailsOver() const;
  bool FailsByFixedNormal(const SmallVector& c, const SmallVector& wrench) const;
  bool FailsByMovingNormal(const SmallVector& c, const SmallVector& wrench) const;
  double TensionSum(double turned) const;

  CdprDescription robot_;
  CableVector low_, high_;              // tension bounds [N]
  CableVector inner_low_, inner_high_;  // bounds that are tightened [N]
  double lever_;                        // divisor of torques: the distance of the farthest attachment [m]
  Eigen::VectorXi motions_;             // entries of a wrench that are rows here, in order
  int rows_, forces_, up_;              // numbers of rows and of forces among them; row of the vertical force
  WrenchBox asked_;             // torques over the lever, as all below; without the wrench of the springs
  WrenchBox required_;          // of the cables at the centre; in Over() at any pose of the set
  Eigen::VectorXd by_springs_;  // largest change of the springs' wrench over the set of poses
  WrenchFeasibility wrenches_;
  TensionDistributor distributor_;
  CableInterference interference_;
  CableKinematics cables_;
  Eigen::MatrixXd structure_;  // torques over the lever
  // Bounds for each cable over the set of poses: the largest change of its direction and of its column, the
  // derivatives of its column with respect to p and theta, and the remainder.
  double distance_ = 0, angle_ = 0;
  Eigen::VectorXd turn_, change_, remainder_;
  std::vector<Matrix6d> derivative_;
  Eigen::VectorXd gain_, spread_;  // |G_i|, and of u_i over the required wrenches
  WrenchMargins margins_;
  CableClearance clearance_;
};

}  // namespace tenon
