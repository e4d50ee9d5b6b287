#pragma once

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/signals/elevation_map.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct MappedGroundParams {
  QuadrupedDescription robot;
  double margin = 0.15;  ///< distance by which the area extends beyond the nominal feet [m]
  Rate rate = Hz(50);
};

/// The plane that fits an elevation map below the robot best, by least squares: over a rectangle along the
/// heading that holds the nominal feet and a margin around them. The planners follow it over stairs, whose
/// steps it averages. Without a map it is level below the trunk.
class MappedGround final : public LeafSystem<MappedGroundParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<ElevationMap> map{this, {"map"}};
  InputPort<LeggedState> state{this, {"state"}};
  OutputPort<GroundPlane> ground{
      this, {"ground"}, Sampled{params.rate}, Uses(map, state), &MappedGround::CalcGround};

 private:
  GroundPlane CalcGround(const ElevationMap& map, const LeggedState& state) const;

  const NominalStance stance_{params.robot};
};

}  // namespace tenon
