#pragma once

#include <tenon/plants/cdpr/elastic_catenary.h>
#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// A cable at rest between an attachment and its anchor, as far as the length that is paid out holds it:
///
///     mass_kg_per_m   pulley_radius_m
///     0               0                 a straight spring, T = EA/l0 (l - l0) if longer than l0, else 0
///     0               > 0               the same, l the length along it, see swivel_pulley.h
///     > 0             0                 an elastic catenary, see elastic_catenary.h, taut or slack
///     > 0             > 0               one that leaves the pulley tangentially
///
/// The pulley turns and swivels without friction or mass; what lies on it has strain and weight, too. In the
/// last case the wrap and the catenary are found by turns; the error shrinks by about the pulley's radius
/// over the cable's length each time. What hangs from the anchor to the winch is not weighed.
struct CableStatics {
  Vec<3> direction_W = Vec<3>::Zero();  ///< unit vector: how it pulls at the attachment
  double length = 0;                    ///< attachment to anchor, along the cable, under strain [m]
  double tension = 0;                   ///< at the anchor, where the winch is [N]
  double tension_loss = 0;              ///< by its weight, from there to the attachment [N]
  double elastic_length =
      0;  ///< EA over the stiffness along direction_W at the attachment; l0 if straight [m]
  double elastic_energy = 0;        ///< [J]
  double potential_energy = 0;      ///< of its weight, 0 at z = 0 [J]
  Vec<3> plane_W = Vec<3>::Zero();  ///< horizontal unit vector from the anchor to the attachment, of a pulley
  Vec<3> exit_W = Vec<3>::Zero();   ///< where it leaves the pulley, or the anchor [m]
  Vec<3> toward_W = Vec<3>::Zero();  ///< horizontal unit vector in which the catenary runs to there
  ElasticCatenary catenary{};        ///< from the attachment to there, if it has weight
};

/// Of cable `index` of `robot`, with `span_W` from its attachment to its anchor, at the gravity [m/s^2].
/// Does not allocate.
/// @throws RunError when the cable has no length, is reeled in completely or ends within its pulley's rim.
CableStatics CalcCableStatics(const CdprDescription& robot, int index, const Vec<3>& span_W,
                              double rest_length, double gravity);

/// The length l0 to pay out for a tension at the anchor [m].
/// @throws RunError also when the cable pulls harder by its own weight, whatever its length.
double CalcRestLength(const CdprDescription& robot, int index, const Vec<3>& span_W, double tension,
                      double gravity);

}  // namespace tenon
