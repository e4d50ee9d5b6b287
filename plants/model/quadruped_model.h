#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>

#include <Eigen/Core>

#include <array>

namespace tenon {

inline constexpr int kNumVelocities = 6 + kNumJoints;
template <int R, int C>
using DynamicsMatrix = Eigen::Matrix<double, R, C, Eigen::DontAlign>;

/// What QuadrupedModel computes of one state. Velocities are nu = (v_W, w_W, qd): of B's origin, of the
/// trunk, of the joints. Then, with forces f_i on the feet,
///
///     M nu' + coriolis + gravity = (0, tau) + sum_i J_i^T f_i.
struct QuadrupedDynamics {
  struct Foot {
    Eigen::Vector3d p_W;        ///< centre of its sphere [m]
    Eigen::Vector3d v_W;        ///< [m/s]
    Eigen::Vector3d bias;       ///< J' nu: its acceleration is J nu' + bias [m/s^2]
    Eigen::Matrix3d J_leg;      ///< J's columns of the leg's own joints [m]
    Eigen::Vector3d w_W;        ///< angular velocity of its shank [rad/s]
    Eigen::Vector3d turn_bias;  ///< the shank's angular acceleration at nu' = 0 [rad/s^2]
  };
  DynamicsMatrix<18, 18> M;  ///< mass matrix, rotors included
  Vec<18> coriolis;          ///< C nu
  Vec<18> gravity;           ///< torque and force that hold against it
  std::array<Foot, kNumLegs> feet;

  Eigen::Vector3d com_W;                    ///< centre of mass x [m]
  Eigen::Vector3d com_velocity_W;           ///< [m/s]
  Eigen::Vector3d com_bias_W;               ///< x'' = M.topRows(3) nu' / m + com_bias [m/s^2]
  Eigen::Matrix3d centroidal_inertia_W;     ///< of the locked robot about its CoM [kg m^2]
  DynamicsMatrix<3, 18> angular_map;        ///< A: angular momentum about the CoM, L = A nu
  Eigen::Vector3d angular_momentum_W;       ///< L [kg m^2/s]
  Eigen::Vector3d angular_momentum_bias_W;  ///< A' nu: L' = A nu' + bias [N m]

  Vec<12> leg_momentum;       ///< p, the joints' rows of M nu [kg m^2/s]
  Vec<12> leg_momentum_rate;  ///< the joints' rows of C^T nu; p' = this + tau - gravity + J_leg^T f [N m]

  std::array<Eigen::Vector3d, kNumJoints> axis_W;    ///< of the joints
  std::array<Eigen::Vector3d, kNumJoints> origin_W;  ///< of the joints [m]
  Eigen::Vector3d base_W;                            ///< p_WB [m]

  const Foot& foot(int leg) const { return feet[static_cast<std::size_t>(leg)]; }
  Vec<18> bias() const { return coriolis + gravity; }
  /// The whole Jacobian of a foot: v_W = J nu.
  DynamicsMatrix<3, 18> FootJacobian(int leg) const;
  /// J_leg of any point p_W that is fixed to the leg's last body.
  Eigen::Matrix3d LegJacobian(int leg, const Eigen::Vector3d& p_W) const;
  /// The foot's point that touches the ground, `arm_W` away from its centre: the radius, against the ground's
  /// normal. There the ground's force acts, and while the foot rolls this point has no velocity, and J nu' +
  /// bias = 0. (That is the acceleration of the centre less alpha x (-arm); the centripetal one of a point
  /// that stays on the sphere is not in it, since the contact wanders.)
  Foot Contact(int leg, const Eigen::Vector3d& arm_W) const;
};

/// The legs apart from the centroidal motion, in the coordinates of Morlando 2023, eqs. (2.1) to (2.3): with
/// b for the trunk's six rows and j for the joints',
///
///     M_q = M_jj - M_jb M_bb^-1 M_bj,   C_q nu = coriolis_j - M_jb M_bb^-1 coriolis_b,
///     J_q = J_leg - J_b M_bb^-1 M_bj,   M_q qdd + C_q nu = tau + J_q^T f,
///
/// which is exact: gravity drops out, and a force on any foot moves all legs. The momentum (2.6) is M_q qd,
/// its rate (2.7) is momentum_rate + tau + J_q^T f, where momentum_rate = M_q' qd - C_q nu; the thesis writes
/// C_q^T qd. What the thesis neglects is the effect of forces that act on the trunk.
struct DecoupledDynamics {
  DynamicsMatrix<12, 12> M_q;
  Vec<12> coriolis;            ///< C_q nu [N m]
  DynamicsMatrix<12, 12> J_q;  ///< rows 3 leg ... 3 leg + 2: of that foot [m]
  Vec<12> momentum;            ///< [kg m^2/s]
  Vec<12> momentum_rate;       ///< [N m]
};

/// The rigid-body model that controllers have of a quadruped, with masses of its own. Rotors add their
/// inertia to the diagonal of M; joint friction is not in it.
///
/// One pass from the trunk to the feet gives poses, velocities and accelerations at nu' = 0; one pass back
/// sums mass, momentum and force of what each joint carries, of which M, the bias, and all momenta are
/// projections (Featherstone 2008, ch. 5 and 6, for a floating trunk with four chains of three). All vectors
/// are in W about B's origin, so that a distant robot loses no digits.
///
/// The leg momentum is p_j = S_j . H_j, with S_j the joint's motion vector and H_j the momentum of what it
/// carries; its rate needs no Coriolis matrix, (C^T nu)_j = (V_j x S_j) . H_j with V_j the velocity of its
/// body. A force on the trunk does not appear in it.
class QuadrupedModel {
 public:
  explicit QuadrupedModel(const QuadrupedDescription& robot, double gravity = kGravity);

  double mass() const { return mass_; }
  double gravity() const { return gravity_; }
  /// Everything of one state, without allocation.
  void Calc(const LeggedState& x, QuadrupedDynamics* out) const;
  /// The decoupled form, from what Calc made of the same state.
  void CalcDecoupled(const LeggedState& x, const QuadrupedDynamics& dynamics, DecoupledDynamics* out) const;

 private:
  struct Body {
    Eigen::Vector3d p_PJ, axis, com;
    Eigen::Matrix3d inertia;
    double mass;
  };

  Body trunk_;
  std::array<Body, kNumJoints> bodies_;
  std::array<Eigen::Vector3d, kNumLegs> feet_;
  double rotor_inertia_, mass_, gravity_;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::QuadrupedDynamics);
