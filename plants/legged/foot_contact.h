#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/surroundings/terrain.h>

namespace tenon {

/// The sphere of a foot, as it moves.
struct FootMotion {
  Vec<3> p_W;  ///< centre [m]
  Vec<3> v_W;  ///< velocity of the centre [m/s]
  Vec<3> w_W;  ///< angular velocity [rad/s]
};

/// What the ground does to a foot.
struct FootContact {
  Vec<3> force_W;       ///< on the foot [N]
  Vec<3> p_W;           ///< where it acts; the centre in the air [m]
  Vec<2> bristle_rate;  ///< [m/s]
  Vec<3> slip_W;        ///< tangential velocity of the foot's point in contact; 0 in the air [m/s]
  double normal_force;  ///< [N]
  double depth;         ///< of the deepest contact; 0 in the air [m]
};

/// The force of the terrain on a spherical foot: a compliant normal force that dissipates, and friction that
/// sticks, with a bristle state z in R^2 [m].
///
/// **Normal** force in each contact of depth d, with its rate d' = -n . v:
///
///     N = k s(d) max(0, 1 + c d'),   s(d) = d^2 / (2 b) for d < b, else d - b / 2,
///
/// with stiffness k, dissipation c (Hunt and Crossley 1975) and blend b. A sphere in several contacts has the
/// sum of their forces, and friction across their mean normal with their mean coefficient mu (by force).
///
/// **Bristle**, with v the tangential velocity of the sphere's material point in contact, so that rolling is
/// not sliding, m = max(mu, mu_0), z_max = m / sigma_0 and alpha a smoothstep of |z| / z_max from 0.7 to 1:
///
///     z_c' = v - alpha max(0, z . v) / z_max^2 z,
///     z'   = g z_c' - (1 - g) z / tau,   g = smoothstep(N / N_0), 1 for N >= N_0.
///
/// Below 0.7 z_max the bristle is elastic, so that it does not ratchet under small vibration as the LuGre
/// model does (Dupont et al. 2002); at z_max it follows without growing further; in the air it is forgotten.
///
/// **Friction** f = -N (mu / m) w min(1, m / |w|) with w = sigma_0 z + sigma_1 z': a cone that is never left.
///
/// **Slippery ground.** The Jacobian of z_c' by z is at most 5 |v| / z_max, so a bristle of mu / sigma_0
/// would be stiff without bound as mu goes to 0. Below mu_0 friction is therefore that of mu_0 times mu /
/// mu_0, both sigmas in proportion to mu: the bristle knows nothing of mu, and the force goes to 0 with it.
/// What it costs is a foot that yields by mu_0 / sigma_0 before it slides, instead of less. Where mu is 0,
/// the bristle is forgotten as in the air.
///
/// What it cannot represent: a difference of static and sliding friction, spinning friction about the normal,
/// and the heat of the deformed ground. z lies in the tangent plane, in the basis that the smallest rotation
/// from W's z axis to the normal gives.
FootContact CalcFootContact(const Terrain& terrain, const ContactProperties& contact, double radius,
                            const FootMotion& foot, const Vec<2>& bristle);

}  // namespace tenon
