#include <tenon/controllers/legged/planning/map_footholds.h>

#include <algorithm>

namespace tenon {

MapPlace Survey(const ElevationMap& map, const Eigen::Vector2d& position, double radius) {
  const Eigen::Array2d place = (position - map.first_W) / map.cell;
  constexpr double kLast = ElevationMap::kSize - 1;
  const Eigen::Array2i first = (place - radius / map.cell).floor().max(0.0).min(kLast).cast<int>();
  const Eigen::Array2i last = (place + radius / map.cell).ceil().max(0.0).min(kLast).cast<int>();
  double count = 0, sum = 0, squares = 0;
  const double level = map.At(first[0], first[1]);
  for (int j = first[1]; j <= last[1]; ++j) {
    for (int i = first[0]; i <= last[0]; ++i) {
      const double h = map.At(i, j) - level;
      ++count, sum += h, squares += h * h;
    }
  }
  const double mean = sum / count;
  return {position, level + mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
}

MapPlace FlatPlace(const ElevationMap& map, const Eigen::Vector2d& wanted, const std::optional<double>& level,
                   const MapFootholdProperties& choice, std::span<const Vec<3>> taken, double climb,
                   double edge_weight) {
  const int reach = static_cast<int>(choice.search / map.cell);
  MapPlace best = Survey(map, wanted, choice.radius);
  double least = std::numeric_limits<double>::infinity();
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d displacement = map.cell * Eigen::Vector2d(i, j);
      const Eigen::Vector2d candidate = wanted + displacement;
      const bool is_free = std::ranges::none_of(
          taken, [&](const Vec<3>& other) { return (candidate - other.head<2>()).norm() < choice.clear; });
      if (!is_free) continue;
      const MapPlace place = Survey(map, candidate, choice.radius);
      if (level && std::abs(place.height - *level) > climb) continue;
      const double cost =
          displacement.norm() + edge_weight * std::max(place.deviation - choice.roughness, 0.0);
      if (cost >= least) continue;
      least = cost;
      best = place;
    }
  }
  return best;
}

double HighestBetween(const ElevationMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const int steps = 1 + static_cast<int>(2 * (to - from).norm() / map.cell);
  double highest = -std::numeric_limits<double>::infinity();
  for (int k = 0; k <= steps; ++k)
    highest = std::max(highest, map.HeightAt(from + static_cast<double>(k) / steps * (to - from)));
  return highest;
}

}  // namespace tenon
