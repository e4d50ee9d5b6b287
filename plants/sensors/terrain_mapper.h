#pragma once

#include <tenon/plants/signals/elevation_map.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Resolution, noise and rate of an elevation map; the defaults are choices. A user may put another source of
/// an ElevationMap in the place of TerrainMapper.
struct TerrainMapProperties {
  double cell = 0.03;   ///< edge of a cell [m]
  double noise = 0.01;  ///< standard deviation of the height of a cell [m]
  double rate_hz = 20;  ///< rate of new maps [Hz]

  static FieldList Fields() {
    return {Field("cell_m", &TerrainMapProperties::cell)
                .Between(0.01, 0.1)
                .Because("the map has 64 x 64 cells and must hold the robot"),
            Field("noise_m", &TerrainMapProperties::noise).AtLeast(0),
            Field("rate_hz", &TerrainMapProperties::rate_hz).Positive()};
  }
};

struct TerrainMapperParams {
  TerrainParams terrain;
  TerrainMapProperties map;
  std::uint64_t seed = 1;  ///< of the noise
};

/// An elevation map as a robot's depth cameras would yield it: the true heights with a random error of each
/// cell, which does not change while the robot walks past. The map lies around the robot and moves and turns
/// with the error of `told`, the state that the controller reads, since cameras measure relative to the
/// robot.
class TerrainMapper final : public LeafSystem<TerrainMapperParams> {
 public:
  explicit TerrainMapper(const TerrainMapperParams& params);

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<LeggedState> told{this, {"told"}};
  OutputPort<ElevationMap> map{
      this, {"map"}, Sampled{Hz(params.map.rate_hz)}, Uses(state, told), &TerrainMapper::CalcMap};

 private:
  void CalcMap(const LeggedState& state, const LeggedState& told, ElevationMap* map) const;

  const Terrain terrain_{params.terrain};
  decltype(ElevationMap::height) noise_;  // repeats with the size of the map [m]
};

}  // namespace tenon
