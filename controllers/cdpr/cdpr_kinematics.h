#pragma once

#include <tenon/plants/model/path.h>

namespace tenon {

/// One column per cable.
using CableMatrix3 = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::DontAlign>;
using CableMatrix6 = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::DontAlign>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Straight cables at one pose of the platform (Morlando 2023, eqs. (3.7) and (3.19)-(3.21)).
///
/// With the platform's CoM at p_WB and its attitude R_WB, cable i runs from the attachment to the anchor:
///
///     arm_i       = R_WB r_i                        CoM to attachment
///     l_i         = a_i - (p_WB + arm_i)            length |l_i|, direction lambda_i = l_i / |l_i|
///     W column i  = [lambda_i ; arm_i x lambda_i]   wrench of a unit tension
///     d|l_i|/dt   = -lambda_i . (v_W + w_W x arm_i) = -(W column i) . [v_W ; w_W]
///
/// All vectors are in W. Wrenches and twists are about the CoM, force before torque, v before w; a tension is
/// positive when the cable pulls the platform towards the anchor, so that W u + [m g ; 0] = 0 at rest, g
/// pointing down. Not modelled: sagging.
///
/// With pulleys (plants/model/swivel_pulley.h), lambda_i points to where the cable leaves its pulley, and
/// |l_i| is the length along pulley and cable from the anchor on. The other equations also hold with pulleys.
/// With pulleys on the platform, arm_i ends where the cable leaves its pulley, and lambda_i points from there
/// to the anchor.
struct CableKinematics {
  CableMatrix3 arm_W;       ///< CoM to attachment, or to the exit of a pulley there [m]
  CableMatrix3 exit_W;      ///< points where the cables leave their pulleys, or the anchors [m]
  CableMatrix3 direction;   ///< lambda, from the attachment towards the exit
  CableVector length;       ///< [m]
  CableVector free_length;  ///< length from the exit on [m]
  CableMatrix3 swivel;      ///< see CableLine; no columns without pulleys
  CableMatrix6 structure;   ///< W: tensions [N] to wrench [N, N m]
  bool carried = false;     ///< the pulleys are on the platform

  int num_cables() const { return static_cast<int>(length.size()); }
};

/// One cable of CableKinematics. If its attachment moves by d, its direction changes by
///
///     d lambda = -((1 - lambda lambda^T) / f - s s^T) d
///
/// with the free length f. The horizontal vector s is normal to the cable with |s|^2 = 1/f - sin(b)/x: the
/// cable turns sideways about the swivel axis, at the distance x, together with the pulley, whose wrap angle
/// is b. Without a pulley s is 0.
struct CableLine {
  Eigen::Vector3d arm_W;
  Eigen::Vector3d exit_W;
  Eigen::Vector3d direction;
  double length = 0;
  double free_length = 0;
  Eigen::Vector3d swivel = Eigen::Vector3d::Zero();  ///< s [1/sqrt(m)]
  Vector6d wrench;                                   ///< its column of W
  double anchor_rate = 0;  ///< rate of the length by the motion of the anchor alone [m/s]
};

/// Computes cable `index` of `robot` at a pose, with its anchor at its place at `time`.
/// @throws RunError if the cable has no length, and therefore no direction, or if it ends on its pulley or
/// beside its swivel axis.
CableLine CalcCableLine(const CdprDescription& robot, int index, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB);
CableLine CalcCableLine(const CdprDescription& robot, int index, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB, const MovingAnchors& anchors, double time);

/// Computes all cables of `robot` at a pose, with its anchors at their places at `time`. Does not allocate if
/// `cables` has the robot's number of cables.
/// @throws RunError as CalcCableLine().
void CalcCableKinematics(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                         const Eigen::Matrix3d& R_WB, CableKinematics* cables,
                         const MovingAnchors& anchors = {}, double time = 0);
CableKinematics CalcCableKinematics(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                    const Eigen::Matrix3d& R_WB);

/// The plane of a planar robot: that of the table, or a vertical one if all anchors are in it, and so are all
/// attachments of a platform with its CoM in it that has only turned about its normal. To first order the
/// tensions neither move the platform out of the plane nor turn it out of it; it swings out of a vertical one
/// like a pendulum.
struct CablePlane {
  int normal = 0;              ///< 0 for a plane of constant x, 1 of constant y, 2 of constant z
  double at = 0;               ///< x, y or z of the plane [m]
  std::array<int, 3> motions;  ///< entries of the twist [v; w], and of a wrench, in the plane
};
/// Returns the plane of a planar robot; empty for all other robots, whose motions are in space.
std::optional<CablePlane> PlaneOf(const CdprDescription& robot);

/// Returns the entries of the twist [v; w], and of a wrench, that the cables govern: those of the plane of a
/// planar robot, otherwise all. Cables that end in one point do not turn the platform about the vertical, nor
/// about any axis if the point is its CoM.
std::vector<int> MotionsOf(const CdprDescription& robot);

/// The wrench of gravity on the platform, [0 0 -m 9.81 0 0] [N, N m]; 0 on a table, which carries it.
Vector6d GravityWrench(const CdprDescription& robot);
/// The wrench of gravity and of the robot's springs (plants/model/platform_springs.h) at a pose [N, N m].
/// `jacobian` receives its derivative with respect to p and theta, see CalcWrenchJacobian().
Vector6d PassiveWrench(const CdprDescription& robot, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                       Matrix6d* jacobian = nullptr);

/// d(W u)/d(p, theta) at constant tensions u, theta a rotation vector in W: R_WB -> exp([theta]x) R_WB.
///
/// Per cable, with P = (I - lambda lambda^T) / f - s s^T (see CableLine) and dlambda = -P (dp + dtheta x
/// arm):
///
///     d(force)  = u dlambda
///     d(torque) = u (arm x dlambda + (dtheta x arm) x lambda)
///
/// Pulleys on the platform turn with it. With the vector c = arm + f lambda from the CoM to the anchor, which
/// moves by d = -dp - dtheta x c as seen from the platform,
///
///     dlambda = dtheta x lambda + P d,   d(torque) = u (dtheta x (c x lambda) + d x lambda + c x P d)
///
/// At an equilibrium under gravity its negative is symmetric: the Hessian, over the poses, of the Lagrangian
/// m g z + sum_i u_i |l_i|. Restricted to motions that keep all cable lengths, W^T x = 0, it is the stiffness
/// of the platform with locked winches.
Matrix6d CalcWrenchJacobian(const CableKinematics& cables, const CableVector& tension);
/// d(W u)/dtheta, the last three columns of CalcWrenchJacobian().
Eigen::Matrix<double, 6, 3> CalcWrenchByTurn(const CableKinematics& cables, const CableVector& tension);

/// The smallest stiffness [N/m] of the platform at an equilibrium with locked winches and inextensible
/// cables. The equilibrium is stable if it is positive.
///
/// The possible motions x = [dp; dtheta] satisfy W^T x = 0. Their potential energy is x^T K x / 2 to second
/// order, with K = -CalcWrenchJacobian() minus the Jacobian of the springs' wrench: gravity is linear in the
/// pose, the lengths are not, and the tensions are the multipliers of the constraints. With M = diag(m 1, R
/// I_B R^T) the result is
///
///     m  min (x^T K x) / (x^T M x)   over  W^T x = 0,
///
/// so sqrt(stiffness / m) [rad/s] is the lowest natural frequency of the suspended platform. The result is
/// infinite if no motion is possible, as is usual with six or more cables. Cables without tension may go
/// slack; they are left out of W because they constrain nothing.
double CalcLockedStiffness(const CdprDescription& robot, const CableKinematics& cables,
                           const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                           const CableVector& tension);

/// -d(wrench)/d(p, theta) [N/m, N, N m] of elastic cables with the winches held, at an equilibrium under
/// gravity with tensions u: the Hessian of the energy sum_i EA (|l_i| - l0_i)^2 / (2 l0_i) + m g z,
///
///     K = sum_i (EA + u_i) / |l_i|  (W column i) (W column i)^T - CalcWrenchJacobian(),      EA / l0 = (EA +
///     u) / |l|
///
/// The second term, the geometric stiffness, is the part that remains if the cables do not stretch. Springs
/// add theirs.
Matrix6d CalcElasticStiffness(const CdprDescription& robot, const CableKinematics& cables,
                              const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                              const CableVector& tension);

/// Returns the smallest force per displacement of the CoM [N/m], over all directions of the force, of a
/// platform with this stiffness that is free to turn: 1 over the largest eigenvalue of the upper left block
/// of K^-1. Returns 0 if K is not positive definite, so that the equilibrium is unstable.
double CalcLeastTranslationalStiffness(const Matrix6d& stiffness);

/// Rest lengths l0 of elastic cables that have the length l under the tension u: l = l0 (1 + u / EA) [m].
CableVector CalcRestLengths(const CableProperties& cable, const CableVector& length,
                            const CableVector& tension);

}  // namespace tenon
