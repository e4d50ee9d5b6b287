#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <algorithm>

namespace tenon {

/// Heights of the ground around a robot, on a square grid along the axes of W. Without a map, `cell` is 0.
struct ElevationMap {
  static constexpr int kSize = 64;  ///< cells along each edge

  double cell = 0;                           ///< edge of a cell [m]
  Vec<2> first_W = Vec<2>::Zero();           ///< centre of the first cell [m]
  std::array<double, kSize * kSize> height;  ///< of cell (i, j) along x and y, at i + kSize j [m]

  ElevationMap() { height.fill(0); }
  bool known() const { return cell > 0; }
  /// Index along x or y of the nearest cell of the map.
  int Index(int axis, double place) const {
    return static_cast<int>(std::lround(std::clamp((place - first_W[axis]) / cell, 0.0, kSize - 1.0)));
  }
  double At(int i, int j) const { return height[i + kSize * j]; }
  double HeightAt(const Eigen::Vector2d& place) const { return At(Index(0, place[0]), Index(1, place[1])); }

  static FieldList Fields() {
    return {{"cell", &ElevationMap::cell, "m"},
            {"first_W", &ElevationMap::first_W, "m"},
            {"height", &ElevationMap::height, "m"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ElevationMap);
