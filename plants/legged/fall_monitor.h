#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/block.h>

#include <numbers>

namespace tenon {

struct FallMonitorParams {
  TerrainParams terrain = {};
  double min_height = 0;   ///< lower bound of the height of B's origin above the ground [m]
  double max_tilt = 1;     ///< upper bound of the angle between the trunk's z axis and the vertical [rad]
  double max_height = 10;  ///< upper bound of the height of B's origin above the ground [m]
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError
};

/// Ends the run when a quadruped has fallen: B's origin is less than min_height above the ground vertically
/// below it, or the trunk is tilted by more than max_tilt. A second monitor ends the run above max_height.
/// The reason contains value and bound.
class FallMonitor final : public LeafSystem<FallMonitorParams> {
 public:
  using LeafSystem::LeafSystem;
  const Terrain terrain{params.terrain};
  InputPort<LeggedState> state{this, {"state"}};
  Parameter<double> min_height{this,
                               {"min_height", "m"},
                               params.min_height,
                               "lower bound of the height of B's origin above the ground",
                               Range().Finite()};
  Parameter<double> max_tilt{this,
                             {"max_tilt", "rad"},
                             params.max_tilt,
                             "upper bound of the trunk's tilt",
                             Range().Above(0).AtMost(std::numbers::pi)};
  Parameter<double> max_height{this,
                               {"max_height", "m"},
                               params.max_height,
                               "upper bound of the height of B's origin above the ground",
                               Range().Finite().OrInfinite()};
  Monitor fall{this, "fall", Sampled{params.rate}, Uses(state, min_height, max_tilt),
               &FallMonitor::CheckFall};
  Monitor flight{this, "flight", Sampled{params.rate}, Uses(state, max_height), &FallMonitor::CheckFlight};

 private:
  double Height(const LeggedState& x) const { return x.p_WB[2] - terrain.At(x.p_WB[0], x.p_WB[1]).height; }
  Verdict CheckFall(const LeggedState& x, double min_height, double max_tilt) const;
  Verdict CheckFlight(const LeggedState& x, double max_height) const;
};

}  // namespace tenon
