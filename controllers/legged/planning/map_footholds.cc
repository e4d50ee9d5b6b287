#include <tenon/controllers/legged/planning/map_footholds.h>
#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/model/quadruped_model.h>

#include <fmt/core.h>

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
                   const MapFootholdProperties& choice, double climb, double edge_weight) {
  const int reach = static_cast<int>(choice.search / map.cell);
  MapPlace best = Survey(map, wanted, choice.radius);
  double least = std::numeric_limits<double>::infinity();
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d displacement = map.cell * Eigen::Vector2d(i, j);
      const MapPlace place = Survey(map, wanted + displacement, choice.radius);
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

namespace {

constexpr double kFullestExtension = 0.95;  // fraction of the leg's length at which J_leg is still regular
constexpr double kWithinRange = 0.98;       // fraction of the extension at the end of the knee's range

}  // namespace

NominalStance::NominalStance(const QuadrupedDescription& robot) {
  LeggedState x;
  x.q = robot.stance;
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot).Calc(x, &dynamics);
  com_B = dynamics.com_W;
  inertia_B = dynamics.centroidal_inertia_W;
  com_height = robot.StanceHeight() + com_B[2];
  center_B.setZero();
  for (const auto& f : dynamics.feet) center_B += f.p_W.head<2>() / kNumLegs;
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    const Eigen::Vector3d p_foot = dynamics.feet[i].p_W;
    foot[i] = p_foot.head<2>() - center_B;
    // The leg turns about its second joint, so height and horizontal reach are bounded by its length.
    const double length = robot.LegLength(static_cast<int>(i));
    const Eigen::Vector3d leg = p_foot - robot.HipPosition(static_cast<int>(i), robot.stance);
    longest[i] =
        std::min(kFullestExtension * length, kWithinRange * robot.LongestExtension(static_cast<int>(i)));
    const double horizontal = longest[i] * longest[i] - leg[2] * leg[2];
    reach[i] = horizontal > 0 ? std::sqrt(horizontal) - leg.head<2>().norm() : 0;
    if (reach[i] <= 0) {
      throw ParameterError(
          fmt::format("the {} leg of '{}' cannot step: in the nominal stance it is stretched to {:.3f} m of "
                      "{:.3f} m; bend the knees of nominal_stance",
                      kLegNames[i], robot.name, leg.norm(), length));
    }
  }
}

}  // namespace tenon
