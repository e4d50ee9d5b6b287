#pragma once

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/motion_signals.h>

#include <numeric>

namespace tenon {

/// The mean of at least one foothold.
inline Eigen::Vector2d CentreOf(std::span<const Eigen::Vector2d> feet) {
  return std::accumulate(feet.begin(), feet.end(), Eigen::Vector2d(0, 0)) / static_cast<double>(feet.size());
}

/// Calls visit(duration, feet) for the phases of the next `steps` steps, from the start of the present step:
/// the stance of all feet, then the swing with the remaining stance feet, of each step. `path` is the
/// commanded path at that start. Footholds are the nominal ones below the path in the middle of each stance,
/// on ground of this slope.
/// In a gait with flight the stance is empty, and each swing lasts until the next touchdown: the feet that
/// stand during a part of it give the mean point of support. All legs of a step with staggered legs swing
/// from the first lift-off to the last touchdown.
template <class Visit>
void ForEachPlannedPhase(const PlanarPath& path, const Vec<2>& slope, const ContactSchedule& schedule,
                         const NominalStance& stance, int steps, Visit&& visit) {
  const GaitTiming& timing = schedule.timing;
  std::array<Eigen::Vector2d, kNumLegs> foot;
  const auto plant = [&](std::size_t leg, double mid_stance) {
    const PlanarPath there = path.At(mid_stance);
    foot[leg] = there.position_W + FootprintOnSlope(slope, there.yaw) * stance.foot[leg];
  };
  const auto steps_ahead = [&](std::size_t leg) {
    return (timing.step[leg] - schedule.step + timing.num_steps) % timing.num_steps;
  };
  for (std::size_t i = 0; i < kNumLegs && timing.num_steps > 0; ++i) {
    const double lift_off = steps_ahead(i) * timing.step_duration() + timing.stance;
    plant(i, lift_off - timing.leg_stance() / 2);
  }
  for (int k = 0; k < steps; ++k) {
    std::array<Eigen::Vector2d, kNumLegs> standing;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kNumLegs; ++i)
      if (steps_ahead(i) != k % timing.num_steps) standing[count++] = foot[i];
    visit(std::max(timing.stance, 0.0), std::span<const Eigen::Vector2d>(foot));
    visit(timing.span() + std::min(timing.stance, 0.0),
          std::span<const Eigen::Vector2d>(standing.data(), count));
    for (std::size_t i = 0; i < kNumLegs; ++i)
      if (steps_ahead(i) == k % timing.num_steps)
        plant(i, (k + 1) * timing.step_duration() + timing.leg_stance() / 2);
  }
}

}  // namespace tenon
