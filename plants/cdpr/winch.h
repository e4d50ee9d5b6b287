#pragma once

#include <tenon/plants/cdpr/layered_drum.h>

namespace tenon {

/// State of a winch.
struct WinchMotion {
  double motor_tension = 0;  ///< T_m, motor's tension at the drum [N]
  double reel_speed = 0;     ///< v, of the drum's circumference; used in torque mode only [m/s]
  double reeling = 1;        ///< rho, current radius of the cable on the drum over that at the start
  bool stands = false;       ///< the drum is locked or stuck
};

/// Rate of the rest length l0 under the tension T at the drum. With b the reel damping:
///
///     tension mode  dl0/dt = rho (T - T_m) / b
///     torque mode   dl0/dt = rho v,   m_eff dv/dt = rho T - T_m - b v
///
/// Commands and measured lengths convert the angle of a drum with layers by the radius at the start, see
/// TurnOf().
double PayOutRate(const WinchProperties& winch, const WinchMotion& motion, double tension);

/// Tension of a cable with the tension T_e by strain and by the rate of its length, and with the damping c:
///
///     T = max(0, T_e - c dl0/dt).
///
/// In tension mode dl0/dt depends on T. With b' = b / rho, inserting it gives T (1 + c/b') = T_e + (c/b')
/// T_m, so T = max(0, (b' T_e + c T_m) / (b' + c)). If the fraction is negative, T = 0 solves both equations.
/// The solution is unique, because T - max(0, T_e - c/b' (T - T_m)) increases with T.
double TensionAtWinch(const WinchProperties& winch, const WinchMotion& motion, double strained,
                      double damping);

/// The turn of cable `index`'s drum when `rest_length` [m] is paid out. Throws RunError if the drum is empty.
DrumTurn DrumTurnAt(const DrumProperties& drum, int index, double rest_length);

/// Tension that two motors at a differential produce for a command of one cable, with the command `other` of
/// its partner; both not negative [N].
double GivenByDifferential(const DifferentialProperties& differential, double asked, double other);

}  // namespace tenon
