#pragma once

#include <tenon/plants/cdpr/elastic_catenary.h>
#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// A cable at rest between an attachment and its anchor, for a given rest length. The model depends on mass
/// and pulley:
///
///     mass_kg_per_m   pulley_radius_m
///     0               0                 a straight spring, T = EA/l0 (l - l0) if longer than l0, else 0
///     0               > 0               a straight spring, l along pulley and cable, see swivel_pulley.h
///     > 0             0                 an elastic catenary, see elastic_catenary.h, taut or slack
///     > 0             > 0               an elastic catenary that leaves the pulley tangentially
///
/// Pulleys on the platform are for straight cables only.
///
/// The pulley has neither friction nor mass; the cable on it has strain and weight. In the last case wrap and
/// catenary are found by fixed-point iteration, whose error shrinks by about the pulley's radius over the
/// cable's length in each step. The cable between anchor and winch has no weight.
struct CableStatics {
  Vec<3> direction_W = Vec<3>::Zero();  ///< unit vector of the force at the attachment
  double length = 0;                    ///< length along the strained cable from attachment to anchor [m]
  double tension = 0;                   ///< tension at the anchor, where the winch is [N]
  double tension_loss = 0;              ///< decrease of the tension by weight, from anchor to attachment [N]
  double elastic_length =
      0;  ///< EA over the stiffness along direction_W at the attachment; l0 if straight [m]
  double elastic_energy = 0;    ///< [J]
  double potential_energy = 0;  ///< potential energy of the cable's weight, 0 at z = 0 [J]
  Vec<3> plane_W =
      Vec<3>::Zero();  ///< with a pulley, horizontal unit vector from the anchor to the attachment
  Vec<3> anchor_W = Vec<3>::Zero();  ///< the anchor [m]
  Vec<3> exit_W = Vec<3>::Zero();    ///< point where the cable leaves the pulley, or the anchor [m]
  Vec<3> lead_W = Vec<3>::Zero();    ///< from the attachment to the exit of its pulley on the platform [m]
  Vec<3> toward_W = Vec<3>::Zero();  ///< horizontal unit vector of the catenary towards exit_W
  ElasticCatenary catenary{};        ///< shape from the attachment to exit_W, if the cable has weight
};

/// Computes the statics of cable `index` of `robot`, with `span_W` from its attachment to its anchor [m] and
/// the gravity [m/s^2], for an anchor at its place at the start. Pulleys on the platform have the attitude
/// R_WB. Does not allocate.
/// @throws RunError if the cable has no length, is reeled in completely, or ends within its pulley's rim.
CableStatics CalcCableStatics(const CdprDescription& robot, int index, const Vec<3>& span_W,
                              double rest_length, double gravity,
                              const Eigen::Matrix3d& R_WB = Eigen::Matrix3d::Identity());

/// Returns the rest length to pay out for a tension at the anchor [m].
/// @throws RunError as CalcCableStatics(), and if the cable's weight alone exceeds the tension at any length.
double CalcRestLength(const CdprDescription& robot, int index, const Vec<3>& span_W, double tension,
                      double gravity, const Eigen::Matrix3d& R_WB = Eigen::Matrix3d::Identity());

}  // namespace tenon
