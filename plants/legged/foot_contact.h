#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/surroundings/terrain.h>

namespace tenon {

/// Motion of a foot's sphere.
struct FootMotion {
  Vec<3> p_W;  ///< centre [m]
  Vec<3> v_W;  ///< velocity of the centre [m/s]
  Vec<3> w_W;  ///< angular velocity [rad/s]
};

/// Contact force on a foot, and the rate of its bristle.
struct FootContact {
  Vec<3> force_W;       ///< on the foot [N]
  Vec<3> p_W;           ///< point where force_W acts; the centre if there is no contact [m]
  Vec<2> bristle_rate;  ///< z' [m/s]
  Vec<3> slip_W;        ///< tangential velocity of the contact point; 0 without contact [m/s]
  double normal_force;  ///< [N]
  double depth;         ///< depth of the deepest contact; 0 without contact [m]
};

/// The force of the terrain on a spherical foot: a compliant, dissipative normal force, and friction with
/// sticking by a bristle state z in R^2 [m].
///
/// **Normal** force in each contact of depth d, with its rate d' = -n . v:
///
///     N = k s(d) max(0, 1 + c d'),   s(d) = d^2 / (2 b) for d < b, else d - b / 2,
///
/// with stiffness k, dissipation c (Hunt and Crossley 1975) and blend b. The normal forces of several
/// contacts are added; friction acts in the plane of their mean normal, with their force-weighted mean
/// coefficient mu.
///
/// **Bristle**, with the tangential velocity v of the sphere's material point in contact (0 for rolling), m =
/// max(mu, mu_0), z_max = m / sigma_0 and alpha a smoothstep of |z| / z_max from 0.7 to 1:
///
///     z_c' = v - alpha max(0, z . v) / z_max^2 z,
///     z'   = g z_c' - (1 - g) z / tau,   g = smoothstep(N / N_0), 1 for N >= N_0.
///
/// Below 0.7 z_max the bristle is elastic, so it does not drift under small vibrations as in the LuGre model
/// (Dupont et al. 2002); at z_max it slides with constant deflection; without contact it decays.
///
/// **Friction** f = -N (mu / m) w min(1, m / |w|) with w = sigma_0 z + sigma_1 z', which always lies in the
/// friction cone.
///
/// **Slippery ground.** The derivative of z_c' with respect to z is bounded by 5 |v| / z_max, so a deflection
/// of mu / sigma_0 would be arbitrarily stiff as mu goes to 0. Below mu_0 the friction is that of mu_0 scaled
/// by mu / mu_0, which scales both sigmas: the bristle does not depend on mu, and the force goes to 0 with
/// mu. Consequently, the foot moves by mu_0 / sigma_0 before it slides. For mu = 0 the bristle decays as
/// without contact.
///
/// **Limitations.** The model has no difference between static and sliding friction, no spinning friction
/// about the normal and no plastic deformation of the ground. z is given in the tangent basis that the
/// smallest rotation from W's z axis to the normal yields.
FootContact CalcFootContact(const Terrain& terrain, const ContactProperties& contact, double radius,
                            const FootMotion& foot, const Vec<2>& bristle);

}  // namespace tenon
