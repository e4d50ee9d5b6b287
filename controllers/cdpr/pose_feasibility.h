#pragma once

#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/controllers/cdpr/wrench_feasibility.h>

#include <Eigen/Core>

#include <array>
#include <vector>

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

/// A neighbourhood of a pose: the CoM within `distance` [m] of p_WB, the platform turned by at most `angle`
/// [rad] from R_WB, about any axis.
struct PoseBall {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  double distance = 0;
  double angle = 0;
};

/// The wrenches [N, N m] that a platform needs: its weight and that of a load at its CoM, any acceleration of
/// both up to `acceleration` along each axis, and any external force and torque up to these along each axis.
struct PlatformDemand {
  double load = 0;          ///< [kg]
  double acceleration = 0;  ///< [m/s^2]
  double force = 0;         ///< [N]
  double torque = 0;        ///< [N m]

  void Validate() const;  ///< throws ParameterError
};
WrenchBox RequiredWrenches(const CdprDescription& robot, const PlatformDemand& demand);

/// Wrench feasibility of a cable robot (it can produce all required wrenches within its tension bounds) at a
/// pose and over a set of poses. For six cables or more, or for a point mass (all attachments at the CoM)
/// with three or more. Pulleys are treated as points.
///
/// A margin at one pose says nothing of those beside it. Over() bounds what can change. If the CoM moves by
/// rho and the platform turns by phi, attachment i moves by no more than rho + 2 sin(phi/2) |arm_i|, which
/// turns its cable by no more than arcsin(move / length), so that its column w_i of W, torques over a lever,
/// changes by no more than some d_i; and to first order by its derivatives, up to a remainder r_i that is a
/// bound of the second ones.
///
/// It holds all over the set: at the centre W u = w for a required wrench w, and elsewhere W + D produces it
/// with u + G y, where G = W^T (W W^T)^-1 is the pseudo-inverse and (1 + D G) y = -D u. There is such a y if
/// eps = sum_i d_i |G_i| < 1, and no tension leaves its bounds if for all cables i
///
///     |G_i| sum_j u_j d_j / (1 - eps) <= the room that u_i has,      or sharper
///     |G_i J x| + |G_i| (sum_j u_j r_j + |D u| eps / (1 - eps)) <= that,      J x = D u to first order
///
/// The first is taken with the tension margin as room, and with bounds of u: upper bounds tighter than the
/// cables', of which the best of a few is taken, and where all cables pull upwards their sum, since
/// sum_j u_j (up . w_j) = up . w. The second is taken with a u for each required wrench: small ones away from
/// the bounds at the middle of the box, see tension_distribution.h, and u + G (w - middle) elsewhere.
///
/// It fails all over the set: a required wrench w is beyond a facet of the centre, c . w > h(c), and still is
/// with every c . w_i larger by what it can change; or with a normal that follows the cables in its facet,
/// whose own products stay zero.
///
/// Rounding apart, both are proofs, as by interval analysis (Gouttefarde, Daney, Merlet, IEEE Trans. Robotics
/// 27(1), 2011, doi:10.1109/TRO.2010.2090064). They become sharp as rho and phi vanish.
class PoseFeasibility {
 public:
  /// `required` has six rows. @throws ParameterError for too few cables; for a robot that makes no sense.
  PoseFeasibility(const CdprDescription& robot, const WrenchBox& required);

  /// Margins at a pose; minus infinity where a cable has no length.
  WrenchMargins At(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  PoseVerdict Over(const PoseBall& poses);
  /// Whether no two cables are nearer than `diameter` [m] and none runs through the platform.
  PoseVerdict IsClearOver(const PoseBall& poses, double diameter);

  /// Results of the last call, at the centre:
  const WrenchMargins& margins() const { return margins_; }
  const CableClearance& clearance() const { return clearance_; }  ///< after IsClearOver()

 private:
  using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  bool Move(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  bool BoundChanges(const PoseBall& poses);
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
  double lever_;  // of torques: the farthest attachment [m]
  int rows_;
  WrenchBox required_;  // torques over the lever
  WrenchFeasibility wrenches_;
  TensionDistributor distributor_;
  CableInterference interference_;
  CableKinematics cables_;
  Eigen::MatrixXd structure_;  // torques over the lever
  // For each cable over the set of poses: the largest change of its direction and of its column; the
  // derivatives of its column by p and theta, and what they leave.
  double distance_ = 0, angle_ = 0;
  Eigen::VectorXd turn_, change_, remainder_;
  std::vector<Matrix6d> derivative_;
  Eigen::VectorXd gain_, spread_;  // |G_i|, and of u_i over the required wrenches
  WrenchMargins margins_;
  CableClearance clearance_;
};

}  // namespace tenon
