#include <tenon/plants/cdpr/layered_drum.h>

#include <numbers>

namespace tenon {

DrumTurn TurnOf(const DrumProperties& drum, double wound) {
  const double full = 2 * std::numbers::pi * drum.turns_per_layer;  // angle of a full layer [rad]
  const double pitch = std::numbers::sqrt3 / 2 * drum.cable_diameter;
  DrumTurn turn{0, drum.radius};
  while (wound > full * turn.radius) {
    wound -= full * turn.radius;
    turn.angle += full;
    turn.radius += pitch;
  }
  turn.angle += wound / turn.radius;
  return turn;
}

}  // namespace tenon
