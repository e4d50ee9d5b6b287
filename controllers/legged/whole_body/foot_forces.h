#pragma once

#include <tenon/plants/model/quadruped_model.h>

namespace tenon {

/// What forces of the ground do at the joints: the sum of J_i^T f_i, joints' rows [N m]. They act where the
/// feet touch the ground, `arm_W` away from their centres: the radius, against the ground's normal [m].
Vec<12> GroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces, const Vec<3>& arm_W);
/// The same of the decoupled legs, see DecoupledDynamics: the sum of J_q^T f_i.
Vec<12> DecoupledGroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces,
                              const Vec<3>& arm_W);

/// The forces at the centres of the feet that do at the joints what `torque` does: J_leg^T f = torque for
/// each leg. A leg is singular if it is straight, or if the foot is below the roll joint's axis; where the
/// smallest singular value s of its Jacobian is below s_0 = min_singular_value [m], f minimises
///
///     |J_leg^T f - torque|^2 + (s_0^2 - s^2) |f|^2,
///
/// so that what the joints cannot feel goes to zero instead of to infinity.
FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const Vec<12>& torque,
                           double min_singular_value);
/// The same of the decoupled legs together, J_q^T f = torque, with the s of the most singular leg.
FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const DecoupledDynamics& decoupled,
                           const Vec<12>& torque, double min_singular_value);

}  // namespace tenon
