#pragma once

#include <tenon/plants/model/quadruped_model.h>

namespace tenon {

/// Joint torques of ground forces: the joints' rows of the sum of J_i^T f_i [N m]. The forces act at the
/// feet's contact points, offset from their centres by `arm_W` (see GroundPlane::ContactArm) [m].
Vec<12> GroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces, const Vec<3>& arm_W);
/// Joint torques of ground forces in the decoupled dynamics (see DecoupledDynamics): the sum of J_q^T f_i [N
/// m].
Vec<12> DecoupledGroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces,
                              const Vec<3>& arm_W);

/// The forces at the feet's centres that are equivalent to joint torques: J_leg^T f = torque for each leg. A
/// leg is singular if it is straight, or if the foot is below the roll joint's axis. Where the smallest
/// singular value s of J_leg is below s_0 = min_singular_value [m], f minimises
///
///     |J_leg^T f - torque|^2 + (s_0^2 - s^2) |f|^2,
///
/// so that the component which hardly affects the joints tends to zero instead of infinity.
FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const Vec<12>& torque,
                           double min_singular_value);
/// Solves J^T f = torque for one force f in the same way, with a leg's Jacobian J of the point where it acts.
Vec<3> SolveForce(const Eigen::Matrix3d& J, const Vec<3>& torque, double min_singular_value);
/// The forces of all legs in the decoupled dynamics, J_q^T f = torque, with s of the most singular leg.
FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const DecoupledDynamics& decoupled,
                           const Vec<12>& torque, double min_singular_value);

}  // namespace tenon
