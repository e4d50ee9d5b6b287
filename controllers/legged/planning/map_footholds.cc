#include <tenon/controllers/legged/planning/map_footholds.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tenon {
namespace {

constexpr double kEdgeWeight = 10;   // displacement per deviation
constexpr double kSameLevel = 0.05;  // difference in height [m]

}  // namespace

MapPlace Survey(const ElevationMap& map, const Eigen::Vector2d& position, double radius) {
  const int reach = static_cast<int>(radius / map.cell), last = ElevationMap::kSize - 1;
  const int x = map.Index(0, position[0]), y = map.Index(1, position[1]);
  double count = 0, sum = 0, squares = 0;
  const double middle = map.At(x, y);
  for (int j = std::max(y - reach, 0); j <= std::min(y + reach, last); ++j) {
    for (int i = std::max(x - reach, 0); i <= std::min(x + reach, last); ++i) {
      const double h = map.At(i, j) - middle;
      ++count, sum += h, squares += h * h;
    }
  }
  const double mean = sum / count;
  return {position, middle + mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
}

MapPlace FlatPlace(const ElevationMap& map, const Eigen::Vector2d& wanted, const std::optional<double>& level,
                   const MapFootholdProperties& choice) {
  const MapPlace at_wanted = Survey(map, wanted, choice.radius);
  const int reach = static_cast<int>(choice.search / map.cell);
  MapPlace best = at_wanted;
  double least = std::numeric_limits<double>::infinity();
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d displacement = map.cell * Eigen::Vector2d(i, j);
      const MapPlace place = Survey(map, wanted + displacement, choice.radius);
      if (level && std::abs(place.height - *level) > kSameLevel) continue;
      const double cost =
          displacement.norm() + kEdgeWeight * std::max(place.deviation - choice.roughness, 0.0);
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
