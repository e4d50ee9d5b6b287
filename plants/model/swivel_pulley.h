#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Kinematics of a cable on a swivelling pulley (Pott, Cable-Driven Parallel Robots, Springer 2018, the
/// chapter on pulley kinematics).
///
/// The cable reaches the anchor from below along the vertical swivel axis, touches the pulley of radius r
/// there, and leaves it tangentially. The pulley turns about the axis towards the attachment, so the cable
/// lies in a vertical plane: x from the axis towards the attachment, z up, the anchor at the origin, the
/// pulley's centre at (r, 0). After the wrap angle b the cable leaves the pulley
///
///     at  r (1 - cos b, sin b)   towards  (sin b, cos b).
///
/// Without sag it is straight from there to the attachment at (x, z), at distance d from the centre:
///
///     free length f = sqrt(d^2 - r^2),   b = atan2(x - r, z) + atan2(r, f),   length = r b + f.
///
/// The gradient of the length with respect to the attachment is the direction in which the cable leaves, so
/// the tension does work only through the length.
///
/// A pulley on the platform has its swivel axis along z of the platform at the attachment, which takes the
/// place of the anchor: the same equations hold in the platform's frame, where the anchor moves.
struct PulleyContact {
  double wrap = 0;         ///< b [rad]
  double free_length = 0;  ///< [m]
};

/// The contact of a straight cable with the pulley; the attachment must lie outside the pulley.
PulleyContact LeaveStraight(double radius, double x, double z);

/// Wrap angle of a direction: its angle from z towards x, from -pi/2 to 3/2 pi [rad].
double WrapOf(double x, double z);

Vec<2> ExitPoint(double radius, double wrap);  ///< [m]

/// A straight cable over its pulley, in W.
struct StraightLead {
  PulleyContact contact;
  Vec<3> outwards_W;   ///< x: horizontal unit vector from the axis towards the attachment
  Vec<3> exit_W;       ///< position of the exit from the anchor [m]
  Vec<3> direction_W;  ///< unit vector from the attachment towards the exit
  double length = 0;   ///< [m]
};

/// `span_W`, which may be in any frame whose z is the swivel axis, is the vector from the attachment, which
/// lies off the axis and outside the pulley, to the anchor [m].
StraightLead LeadStraight(double radius, const Vec<3>& span_W);

}  // namespace tenon
