#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// How a cable leaves a pulley that swivels (Pott, Cable-Driven Parallel Robots, Springer 2018, the chapter
/// on pulley kinematics).
///
/// The cable comes to the anchor from below along the vertical swivel axis, touches the pulley of radius r
/// there, and leaves it tangentially. The pulley turns about the axis to where the cable goes, so that all
/// lies in one vertical plane: x from the axis towards the attachment, z up, the anchor at the origin, the
/// pulley's centre at (r, 0). After the wrap b the cable leaves
///
///     at  r (1 - cos b, sin b)   towards  (sin b, cos b).
///
/// Without sag it goes on straight to the attachment at (x, z), at distance d from the centre:
///
///     free length f = sqrt(d^2 - r^2),   b = atan2(x - r, z) + atan2(r, f),   length = r b + f.
///
/// Its gradient with respect to the attachment is the direction in which the cable leaves, so the tension
/// does no work but by the length.
struct PulleyContact {
  double wrap = 0;         ///< b [rad]
  double free_length = 0;  ///< [m]
};

/// The contact of a straight cable; the attachment must lie outside of the pulley.
PulleyContact LeaveStraight(double radius, double x, double z);

/// Of directions, the angle from straight up towards x, from -90 to 270 deg, as wraps are counted [rad].
double WrapOf(double x, double z);

Vec<2> ExitPoint(double radius, double wrap);  ///< [m]

/// A straight cable over its pulley, in W.
struct StraightLead {
  PulleyContact contact;
  Vec<3> outwards_W;   ///< x: horizontal unit vector from the axis towards the attachment
  Vec<3> exit_W;       ///< from the anchor [m]
  Vec<3> direction_W;  ///< unit vector from the attachment towards the exit
  double length = 0;   ///< [m]
};

/// `span_W` goes from the attachment, which lies beside the axis and outside of the pulley, to the anchor.
StraightLead LeadStraight(double radius, const Vec<3>& span_W);

}  // namespace tenon
