#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

inline constexpr int kNumVelocities = 6 + kNumJoints;
template <int R, int C>
using DynamicsMatrix = Eigen::Matrix<double, R, C, Eigen::DontAlign>;

/// Dynamics of a quadruped in one state, computed by QuadrupedModel. With the velocities nu = (v_W, w_W, qd)
/// of B's origin, the trunk and the joints, and forces f_i on the feet,
///
///     M nu' + coriolis + gravity = (0, tau) + sum_i J_i^T f_i.
struct QuadrupedDynamics {
  struct Foot {
    Eigen::Vector3d p_W;        ///< centre of the foot's sphere [m]
    Eigen::Vector3d v_W;        ///< velocity of the centre [m/s]
    Eigen::Vector3d bias;       ///< J' nu: the centre's acceleration is J nu' + bias [m/s^2]
    Eigen::Matrix3d J_leg;      ///< columns of J of the leg's joints [m]
    Eigen::Vector3d w_W;        ///< angular velocity of the shank [rad/s]
    Eigen::Vector3d turn_bias;  ///< angular acceleration of the shank at nu' = 0 [rad/s^2]
  };
  DynamicsMatrix<18, 18> M;  ///< mass matrix, rotors included
  Vec<18> coriolis;          ///< C nu
  Vec<18> gravity;           ///< generalised forces that compensate gravity
  std::array<Foot, kNumLegs> feet;

  Eigen::Vector3d com_W;                    ///< centre of mass x [m]
  Eigen::Vector3d com_velocity_W;           ///< [m/s]
  Eigen::Vector3d com_bias_W;               ///< x'' = M.topRows(3) nu' / m + com_bias [m/s^2]
  Eigen::Matrix3d centroidal_inertia_W;     ///< inertia of the locked robot about its CoM [kg m^2]
  DynamicsMatrix<3, 18> angular_map;        ///< A: angular momentum about the CoM, L = A nu
  Eigen::Vector3d angular_momentum_W;       ///< L [kg m^2/s]
  Eigen::Vector3d angular_momentum_bias_W;  ///< A' nu: L' = A nu' + bias [N m]

  Vec<12> leg_momentum;       ///< p, the joints' rows of M nu [kg m^2/s]
  Vec<12> leg_momentum_rate;  ///< the joints' rows of C^T nu; p' = this + tau - gravity + J_leg^T f [N m]

  std::array<Eigen::Vector3d, kNumJoints> axis_W;    ///< axes of the joints
  std::array<Eigen::Vector3d, kNumJoints> origin_W;  ///< origins of the joints [m]
  Eigen::Vector3d base_W;                            ///< p_WB [m]

  const Foot& foot(int leg) const { return feet[leg]; }
  Vec<18> bias() const { return coriolis + gravity; }
  /// Jacobian J of a foot: v_W = J nu.
  DynamicsMatrix<3, 18> FootJacobian(int leg) const;
  /// J_leg of a point p_W [m] fixed to the leg's last body.
  Eigen::Matrix3d LegJacobian(int leg, const Eigen::Vector3d& p_W) const;
  /// The foot's contact point, offset from its centre by `arm_W` (see GroundPlane::ContactArm) [m]. The
  /// ground force acts there, and while the foot rolls its velocity is 0 and J nu' + bias = 0. (The bias
  /// excludes the centripetal acceleration of a material point, since the contact point moves on the sphere.)
  Foot Contact(int leg, const Eigen::Vector3d& arm_W) const;
};

/// Dynamics of the legs, decoupled from the centroidal motion, in the coordinates of Morlando 2023, eqs.
/// (2.1) to (2.3). With index b for the trunk's six rows and j for the joints' rows,
///
///     M_q = M_jj - M_jb M_bb^-1 M_bj,   C_q nu = coriolis_j - M_jb M_bb^-1 coriolis_b,
///     J_q = J_leg - J_b M_bb^-1 M_bj,   M_q qdd + C_q nu = tau + J_q^T f,
///
/// which is exact: gravity cancels, and a force on any foot accelerates all legs. The momentum (2.6) is M_q
/// qd; its rate (2.7) is momentum_rate + tau + J_q^T f with momentum_rate = M_q' qd - C_q nu, which the
/// thesis writes as C_q^T qd. Forces on the trunk are neglected.
struct DecoupledDynamics {
  DynamicsMatrix<12, 12> M_q;
  Vec<12> coriolis;            ///< C_q nu [N m]
  DynamicsMatrix<12, 12> J_q;  ///< rows 3 leg to 3 leg + 2 of each foot [m]
  Vec<12> momentum;            ///< M_q qd [kg m^2/s]
  Vec<12> momentum_rate;       ///< M_q' qd - C_q nu [N m]
};

/// Rigid-body model of a quadruped for controllers. The rotors' inertia is added to the diagonal of M; joint
/// friction is not modelled.
///
/// A pass from the trunk to the feet computes poses, velocities and accelerations at nu' = 0; a pass back
/// sums mass, momentum and force of the bodies that each joint carries. M, the bias and all momenta are
/// projections of these sums (Featherstone 2008, ch. 5 and 6, for a floating base with four chains of three
/// joints). All vectors are in W about B's origin, so precision does not depend on the distance from W's
/// origin.
///
/// The leg momentum is p_j = S_j . H_j, with the motion vector S_j of joint j and the momentum H_j of the
/// bodies it carries. Its rate needs no Coriolis matrix: (C^T nu)_j = (V_j x S_j) . H_j with the velocity V_j
/// of the joint's body. Forces on the trunk do not change it.
class QuadrupedModel {
 public:
  explicit QuadrupedModel(const QuadrupedDescription& robot, double gravity = kGravity);

  double mass() const { return mass_; }
  double gravity() const { return gravity_; }
  /// Computes the dynamics of one state. Does not allocate.
  void Calc(const LeggedState& x, QuadrupedDynamics* out) const;
  /// Calc(), as the function of a Shared: blocks with equal models of one state compute its dynamics once.
  void operator()(const LeggedState& x, QuadrupedDynamics* out) const { Calc(x, out); }
  friend bool operator==(const QuadrupedModel&, const QuadrupedModel&) = default;
  /// Computes the decoupled dynamics from `dynamics`, the result of Calc() for x. Does not allocate.
  void CalcDecoupled(const LeggedState& x, const QuadrupedDynamics& dynamics, DecoupledDynamics* out) const;

 private:
  struct Body {
    Eigen::Vector3d p_PJ, axis, com;
    Eigen::Matrix3d inertia;
    double mass;
    friend bool operator==(const Body&, const Body&) = default;
  };

  Body trunk_;
  std::array<Body, kNumJoints> bodies_;
  std::array<Eigen::Vector3d, kNumLegs> feet_;
  double rotor_inertia_, mass_, gravity_;
};

/// A robot at rest on a plane, with B's origin near the plane's point p_W, the trunk parallel to the plane,
/// and this heading [rad]. Seen from above, the feet have their positions of the nominal stance relative to
/// the trunk, and the CoM its nominal height: on a slope, too, the legs are vertical and the CoM is above the
/// centre of the feet. `feet_shift` displaces the feet horizontally from there [m]. Throws ParameterError if
/// a leg does not reach the ground within the ranges of its joints.
LeggedState StandingOn(const QuadrupedDescription& robot, const GroundPlane& ground, double yaw = 0,
                       const Vec<2>& feet_shift = Vec<2>::Zero());

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::QuadrupedDynamics);
