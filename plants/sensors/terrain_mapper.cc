#include <tenon/plants/sensors/terrain_mapper.h>

#include <Eigen/Geometry>

namespace tenon {

TerrainMapper::TerrainMapper(const TerrainMapperParams& params) : LeafSystem(params) {
  RandomStream random(params.seed, "terrain_map");
  for (double& error : noise_) error = params.map.noise * random.Normal();
}

void TerrainMapper::CalcMap(const LeggedState& state, const LeggedState& told, ElevationMap* map) const {
  constexpr int n = ElevationMap::kSize;
  const double cell = params.map.cell;
  const Eigen::Vector3d is = state.R_WB().col(0), seems = told.R_WB().col(0);
  const Eigen::Rotation2Dd turn(std::atan2(is[1], is[0]) - std::atan2(seems[1], seems[0]));
  const Eigen::Array2d corner = (told.p_WB.head<2>().array() / cell).round() - n / 2;
  map->cell = cell;
  map->first_W = cell * corner;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d place = map->first_W + cell * Eigen::Vector2d(i, j);
      const Eigen::Vector2d there = state.p_WB.head<2>() + turn * (place - told.p_WB.head<2>());
      const auto wrapped = [](double index) { return (static_cast<int>(index) % n + n) % n; };
      const int of_noise = wrapped(corner[0] + i) + n * wrapped(corner[1] + j);
      map->height[static_cast<std::size_t>(i + n * j)] = terrain_.At(there[0], there[1]).height +
                                                         told.p_WB[2] - state.p_WB[2] +
                                                         noise_[static_cast<std::size_t>(of_noise)];
    }
  }
}

}  // namespace tenon
