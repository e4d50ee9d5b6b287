#include <tenon/plants/cdpr/winch.h>

#include <fmt/format.h>

#include <algorithm>

namespace tenon {

double PayOutRate(const WinchProperties& winch, const WinchMotion& motion, double tension) {
  if (motion.stands) return 0;
  if (winch.mode == WinchMode::kTorque) return motion.reeling * motion.reel_speed;
  return motion.reeling * ((tension - motion.motor_tension) / winch.reel_damping);
}

double TensionAtWinch(const WinchProperties& winch, const WinchMotion& motion, double strained,
                      double damping) {
  if (motion.stands) return std::max(0.0, strained);
  if (winch.mode == WinchMode::kTorque)
    return std::max(0.0, strained - damping * (motion.reeling * motion.reel_speed));
  const double reel_damping = winch.reel_damping / motion.reeling;
  return std::max(0.0, (reel_damping * strained + damping * motion.motor_tension) / (reel_damping + damping));
}

DrumTurn DrumTurnAt(const DrumProperties& drum, int index, double rest_length) {
  if (rest_length > drum.cable_length)
    throw RunError(fmt::format(
        "cable {} is paid out by {} m, more than the {} m that it has; give more cable_length_m or move the "
        "platform nearer to the anchor",
        index, rest_length, drum.cable_length));
  return TurnOf(drum, drum.cable_length - rest_length);
}

double GivenByDifferential(const DifferentialProperties& differential, double asked, double other) {
  const double limit = differential.motor_tension_max;
  return std::clamp((asked + other) / 2, -limit, limit) + std::clamp((asked - other) / 2, -limit, limit);
}

}  // namespace tenon
