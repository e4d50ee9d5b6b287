#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/signals/cdpr_signals.h>

#include <vector>

namespace tenon {

/// By how much attitude and tensions differ from those of a static equilibrium without load.
struct ReferenceShift {
  Vec<3> turn_W = Vec<3>::Zero();  ///< R -> exp([turn]x) R [rad]
  CableVector tension;             ///< [N]; without entries none
  bool held = true;                ///< whether the cables that are left could hold the platform

  static FieldList Fields() {
    return {{"turn_W", &ReferenceShift::turn_W, "rad"},
            {"tension", &ReferenceShift::tension, "N"},
            {"held", &ReferenceShift::held}};
  }
};

/// The attitude and the tensions with which a platform carries a load at the reference's place and
/// accelerates as the reference does: those next to the static equilibrium of the reference with
///
///     W(p, R) u + [m ; 0] (g - a) + [m_L ; R r x m_L] (g - a) + [f ; tau] = 0,
///
/// a the reference's acceleration, m_L a point mass at r, f and tau what else acts about the platform's CoM.
/// Next means: of least |du|^2 + |turn / 1 mrad|^2 [N^2], with a broken cable |turn / 0.01 mrad|^2, turns
/// added as vectors; with a load or a broken cable tensions are within the robot's bounds, if enough of them
/// are. Four and five cables leave one or two parameters free, more of them the attitude altogether. Cables
/// that are broken have no tension, and the others carry their part. Without load and with all cables the
/// equation is taken to first order about the equilibrium; else Newton's method, a step of it a call, goes on
/// from the shift of the call before: what changes slowly it follows to rounding.
class BalancedReference {
 public:
  explicit BalancedReference(const CdprDescription& robot) : robot_(robot) {}

  /// From `at` and the shift found before, which becomes the new one (0 without load and with all cables).
  /// `broken` has a 1 for a cable that is, else 0; without entries none is. Without allocations from the
  /// second call on.
  /// @throws RunError as CalcCableLine().
  void Calc(const CdprReference& at, const LoadEstimate& load, const CableVector& broken,
            ReferenceShift& shift);

  const Eigen::Vector3d& euler() const { return euler_; }  ///< ZYX [rad], next to the reference's
  const CableVector& tension() const { return tension_; }  ///< [N]
  const Eigen::Matrix3d& R_WB() const { return R_WB_; }    ///< the same; without load, the reference's

 private:
  CdprDescription robot_;
  CableKinematics cables_;
  Eigen::Matrix3d R_WB_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d euler_ = Eigen::Vector3d::Zero();
  CableVector tension_;
  std::vector<char> held_;  // cables at a bound, or broken
};

}  // namespace tenon
