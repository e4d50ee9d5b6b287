#pragma once

#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/signals/cdpr_signals.h>

namespace tenon {

/// Difference of attitude and tensions from the static equilibrium without load.
struct ReferenceShift {
  Vec<3> turn_W = Vec<3>::Zero();  ///< R -> exp([turn]x) R [rad]
  CableVector tension;             ///< [N]; empty means zero
  bool held = true;                ///< true if the intact cables can hold the platform

  static FieldList Fields() {
    return {{"turn_W", &ReferenceShift::turn_W, "rad"},
            {"tension", &ReferenceShift::tension, "N"},
            {"held", &ReferenceShift::held}};
  }
};

/// The attitude and the tensions with which a platform carries a load and accelerates like its reference.
/// They solve
///
///     W(p, R) u + [m ; 0] (g - a) + w_s(p, R) + [m_L ; R r x m_L] (g - a) + [f ; tau] = 0
///
/// at the reference's position p. w_s is the wrench of the robot's springs, a is the reference's
/// acceleration, m_L a point mass at r, and f and tau are the remaining load about the platform's CoM.
///
/// The solution that is computed is the nearest one to the static equilibrium of the reference: it minimises
/// |du|^2 + |turn / 1 mrad|^2 [N^2], or |du|^2 + |turn / 0.01 mrad|^2 with a broken cable. Turns are added as
/// vectors. With a load or a broken cable the tensions stay within the robot's bounds, as far as the number
/// of cables permits: four and five cables leave one and two free parameters, six and more the whole
/// attitude. Broken cables have no tension.
///
/// A planar robot balances the forces in its plane (CablePlane) and remains in it; those out of it make its
/// platform swing.
///
/// Without load and with all cables intact, the equation is linearised at the equilibrium. Otherwise each
/// call takes one step of Newton's method from the shift of the last call; this follows slow changes to
/// rounding.
class BalancedReference {
 public:
  explicit BalancedReference(const CdprDescription& robot)
      : robot_(robot), anchors_(robot), motions_(MotionsOf(robot)) {}

  /// Balances the reference `at`, of `time` [s], when moving anchors have their places. `shift` is the start
  /// of the search and its result; without load and with all cables intact it is set to 0. `broken` has a 1
  /// for each broken cable, else 0; if it is empty, all cables are intact. Does not allocate from the second
  /// call on.
  /// @throws RunError as CalcCableLine().
  void Calc(const CdprReference& at, const LoadEstimate& load, const CableVector& broken,
            ReferenceShift& shift, double time = 0);

  const Eigen::Vector3d& euler() const { return euler_; }  ///< ZYX angles near those of the reference [rad]
  const CableVector& tension() const { return tension_; }  ///< [N]
  const Eigen::Matrix3d& R_WB() const { return R_WB_; }    ///< attitude; that of the reference without load

 private:
  CdprDescription robot_;
  MovingAnchors anchors_;
  std::vector<int> motions_;
  CableKinematics cables_;
  Eigen::Matrix3d R_WB_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d euler_ = Eigen::Vector3d::Zero();
  CableVector tension_;
  std::vector<char> held_;  // cables at a bound, or broken
};

}  // namespace tenon
