#pragma once

#include <tenon/plants/cdpr/layered_drum.h>

namespace tenon {

/// What a winch does at an instant.
struct WinchMotion {
  double motor_tension = 0;  ///< T_m, what the motor pulls at the drum [N]
  double reel_speed = 0;     ///< v, of the drum's circumference in torque mode; else without meaning [m/s]
  double reeling = 1;        ///< rho, where the cable lies now over where it lay at the start
  bool stands = false;       ///< the drum is locked or stuck
};

/// A winch lets its cable out by the tension T at its drum. With b the reel damping:
///
///     tension mode  dl0/dt = rho (T - T_m) / b
///     torque mode   dl0/dt = rho v,   m_eff dv/dt = rho T - T_m - b v
///
/// A drum with layers has turned by `angle` since it was empty, see TurnOf; on the radius of the start that
/// would have been another length. By it commands and lengths are told.
double PayOutRate(const WinchProperties& winch, const WinchMotion& motion, double tension);

/// The tension of a cable that pulls with T_e, by its strain and the rate of its own length, and by its
/// damping c with c dl0/dt less,
///
///     T = max(0, T_e - c dl0/dt).
///
/// In tension mode T depends on that speed: put in with b' = b / rho, T (1 + c/b') = T_e + (c/b') T_m, so T =
/// max(0, (b' T_e + c T_m) / (b' + c)). (If the fraction is negative, T = 0 solves both equations; as T -
/// max(0, T_e - c/b' (T - T_m)) increases with T, there is no other solution.)
double TensionAtWinch(const WinchProperties& winch, const WinchMotion& motion, double strained,
                      double damping);

/// The turn of cable `index`'s drum when `rest_length` [m] is paid out. Throws RunError if it has no more.
DrumTurn DrumTurnAt(const DrumProperties& drum, int index, double rest_length);

/// What two motors at a differential can give of the tension asked of one cable, with `other` asked of its
/// partner; both not negative [N].
double GivenByDifferential(const DifferentialProperties& differential, double asked, double other);

}  // namespace tenon
