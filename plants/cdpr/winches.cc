#include <tenon/plants/cdpr/cable_fault.h>
#include <tenon/plants/cdpr/layered_drum.h>
#include <tenon/plants/cdpr/winch.h>
#include <tenon/plants/cdpr/winch_errors.h>

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

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

void WinchErrors::Draw(RandomStream& random, CableVector* gain) const {
  gain->resize(params.num_cables);
  for (double& each : *gain) each = params.gain_deviation * random.Normal();
}

void WinchErrors::CalcTension(const CableVector& command, const CableSignals& cables, const CableVector& gain,
                              RandomStream& random, CableVector* tension) const {
  for (const auto& [name, size] :
       {std::pair{"command", command.size()}, std::pair{"cables", cables.length_rate.size()}})
    if (size != params.num_cables)
      throw RunError(fmt::format("'{}' has {} cables, num_cables is {}", name, size, params.num_cables));
  for (Eigen::Index i = 0; i < tension->size(); ++i) {
    const double rubs = 1 + params.friction * std::tanh(cables.length_rate[i] / params.friction_speed);
    (*tension)[i] = (1 + gain[i]) * (1 + params.ripple * random.Normal()) * rubs * command[i];
  }
}

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

void CableFaultParams::Validate() const {
  Demand(num_cables > 0, fmt::format("num_cables = {} must be the number of the robot's cables", num_cables));
  for (const int i : cables)
    Demand(i >= 0 && i < num_cables, fmt::format("there is no cable {}: give 0 to {}", i, num_cables - 1));
  Demand(kind != CableFaultKind::kBroken || std::isinf(schedule.duration),
         fmt::format("schedule.duration = {}, but a broken cable stays broken: leave it infinite",
                     schedule.duration));
}

bool CableFault::CalcActing(double time, const FaultSchedule& schedule, bool active, bool& acted) const {
  const bool acts = active && schedule.Acts(time, params.rate);
  acted = acted || acts;
  return params.kind == CableFaultKind::kBroken ? acted : acts;
}

void CableFault::CalcFaults(const CableFaults& others, bool acting, CableFaults* out) const {
  const auto take_over = [&](const CableVector& from, CableVector& to) {
    if (from.size() == 0)
      to.setZero();
    else if (from.size() == to.size())
      to = from;
    else
      throw RunError(fmt::format("`others` are of {} cables, but num_cables is {}: give both the robot's",
                                 from.size(), to.size()));
  };
  take_over(others.stuck, out->stuck);
  take_over(others.broken, out->broken);
  if (!acting) return;
  CableVector& own = params.kind == CableFaultKind::kBroken ? out->broken : out->stuck;
  for (const int i : params.cables) own[i] = 1;
  if (params.cables.empty()) own.setOnes();
}

}  // namespace tenon
